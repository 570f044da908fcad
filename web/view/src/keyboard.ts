// Keys on the picture: a probe without a pointer.
import type { Hands } from './hands.js';

const arrows: Readonly<Record<string, readonly [number, number]>> = {
  ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1],
};

export function listenToKeys(canvas: HTMLCanvasElement, actions: Hands): void {
  const others: Readonly<Record<string, () => void>> = {
    n: () => actions.nextNode(1),
    b: () => actions.nextNode(-1),
    PageDown: () => actions.move([0, 0, 1]),
    PageUp: () => actions.move([0, 0, -1]),
    i: () => actions.press(1),
    o: () => actions.press(-1),
    p: () => actions.pin(),
    Escape: () => actions.letGo(),
    '+': () => actions.zoom(1 / 1.15),
    '=': () => actions.zoom(1 / 1.15),
    '-': () => actions.zoom(1.15),
    s: () => actions.otherMode(),
  };
  canvas.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const arrow = arrows[event.key];
    if (arrow && event.shiftKey) actions.turn(-24 * arrow[0], 24 * arrow[1]);
    else if (arrow) actions.move([arrow[0], arrow[1], 0]);
    else {
      const action = others[event.key.length === 1 ? event.key.toLowerCase() : event.key];
      if (!action) return;
      action();
    }
    event.preventDefault();
  });
}
