// Mouse, pen and fingers on the picture, translated into what they mean.

/** @template T  what a pointer can hold: a tool */
export interface Gestures<T extends object> {
  /** A tool at this pixel; null: beside the body. @param others  tools that other pointers hold */
  grab(x: number, y: number, others: readonly T[]): T | null;
  /** The pointer of a tool is at dx, dy pixels from where it grabbed. */
  across(tool: T, dx: number, dy: number): void;
  /** The tool moves by so many pixels away from the viewer. */
  away(tool: T, pixels: number): void;
  turn(dx: number, dy: number): void;
  shift(dx: number, dy: number): void;
  /** closer: below 1 */
  zoom(factor: number): void;
}

interface Pointer<T> {
  /** what it holds; otherwise it turns or shifts the view */
  readonly tool: T | null;
  readonly shifts: boolean;
  readonly beginX: number;
  readonly beginY: number;
  x: number;
  y: number;
}

export function listenToPointers<T extends object>(canvas: HTMLCanvasElement, gestures: Gestures<T>): void {
  const pointers = new Map<number, Pointer<T>>();
  const at = (event: MouseEvent) => {
    const box = canvas.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  };
  const tools = () => [...pointers.values()].flatMap(({ tool }) => tool ?? []);

  canvas.addEventListener('pointerdown', (event) => {
    const { x, y } = at(event), view = event.button !== 0 || event.ctrlKey || event.metaKey;
    canvas.setPointerCapture(event.pointerId);
    const tool = view ? null : gestures.grab(x, y, tools());
    pointers.set(event.pointerId, { tool, shifts: event.button !== 0, beginX: x, beginY: y, x, y });
    canvas.classList.add('dragging');
    event.preventDefault();
  });

  canvas.addEventListener('pointermove', (event) => {
    const { x, y } = at(event), pointer = pointers.get(event.pointerId);
    if (!pointer) return;
    const dx = x - pointer.x, dy = y - pointer.y;
    const other = [...pointers.values()].find((p) => p !== pointer && !p.tool);
    if (pointer.tool) gestures.across(pointer.tool, x - pointer.beginX, y - pointer.beginY);
    else if (other) {
      const before = Math.hypot(pointer.x - other.x, pointer.y - other.y), after = Math.hypot(x - other.x, y - other.y);
      gestures.shift(dx / 2, dy / 2);
      if (before > 10 && after > 10) gestures.zoom(before / after);
    } else if (pointer.shifts || event.shiftKey) gestures.shift(dx, dy);
    else gestures.turn(dx, dy);
    pointer.x = x;
    pointer.y = y;
  });

  for (const end of ['pointerup', 'pointercancel'] as const)
    canvas.addEventListener(end, (event) => {
      pointers.delete(event.pointerId);
      if (pointers.size === 0) canvas.classList.remove('dragging');
    });
  canvas.addEventListener('contextmenu', (event) => event.preventDefault());

  canvas.addEventListener('wheel', (event) => {
    event.preventDefault();
    const lines = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 33 : event.deltaMode === WheelEvent.DOM_DELTA_PAGE ? 300 : 1;
    const [tool] = tools();
    if (tool) gestures.away(tool, -0.1 * event.deltaY * lines);
    else gestures.zoom(Math.exp(0.0015 * event.deltaY * lines));
  }, { passive: false });
}
