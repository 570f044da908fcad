// Mouse, pen and fingers on the picture, translated into what they mean.

export interface Gestures {
  /** A tool or sphere at this pixel; null: beside the body. `more`: other pointers hold tools already. */
  grab(x: number, y: number, more: boolean): number | null;
  /** The pointer of a tool is at dx, dy pixels from where it grabbed. */
  across(tool: number, dx: number, dy: number): void;
  /** The tool moves by so many pixels away from the viewer. */
  away(tool: number, pixels: number): void;
  release(tool: number): void;
  turn(dx: number, dy: number): void;
  shift(dx: number, dy: number): void;
  /** closer: below 1 */
  zoom(factor: number): void;
  /** the tool that the wheel moves when none is dragged */
  readonly lastTool: number | null;
}

type Role = { kind: 'tool'; tool: number; alongX: number; alongY: number } | { kind: 'turn' } | { kind: 'shift' };
interface Pointer {
  role: Role;
  beginX: number;
  beginY: number;
  x: number;
  y: number;
}

export function listenToPointers(canvas: HTMLCanvasElement, gestures: Gestures): void {
  const pointers = new Map<number, Pointer>();
  const at = (event: MouseEvent) => {
    const box = canvas.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  };
  const holding = () => [...pointers.values()].filter((pointer) => pointer.role.kind === 'tool');
  const cameras = () => [...pointers.values()].filter((pointer) => pointer.role.kind !== 'tool');

  canvas.addEventListener('pointerdown', (event) => {
    const { x, y } = at(event);
    canvas.focus({ preventScroll: true });
    canvas.setPointerCapture(event.pointerId);
    const view = event.button !== 0 || event.ctrlKey || event.metaKey;
    const tool = view ? null : gestures.grab(x, y, holding().length > 0);
    const role: Role = tool !== null ? { kind: 'tool', tool, alongX: 0, alongY: 0 } : { kind: event.button !== 0 ? 'shift' : 'turn' };
    pointers.set(event.pointerId, { role, beginX: x, beginY: y, x, y });
    canvas.classList.add('dragging');
    event.preventDefault();
  });

  canvas.addEventListener('pointermove', (event) => {
    const { x, y } = at(event), pointer = pointers.get(event.pointerId);
    if (!pointer) return;
    const dx = x - pointer.x, dy = y - pointer.y, { role } = pointer;
    if (role.kind === 'tool') {
      if (event.altKey) {
        gestures.away(role.tool, -dy);
        role.alongX += dx;
        role.alongY += dy;
      } else gestures.across(role.tool, x - pointer.beginX - role.alongX, y - pointer.beginY - role.alongY);
    } else if (cameras().length === 2) {
      const other = cameras().find((p) => p !== pointer)!;
      const before = Math.hypot(pointer.x - other.x, pointer.y - other.y), after = Math.hypot(x - other.x, y - other.y);
      gestures.shift(dx / 2, dy / 2);
      if (before > 10 && after > 10) gestures.zoom(before / after);
    } else if (role.kind === 'shift' || event.shiftKey) gestures.shift(dx, dy);
    else gestures.turn(dx, dy);
    pointer.x = x;
    pointer.y = y;
  });

  const end = (event: PointerEvent) => {
    const pointer = pointers.get(event.pointerId);
    pointers.delete(event.pointerId);
    if (pointer?.role.kind === 'tool') gestures.release(pointer.role.tool);
    if (pointers.size === 0) canvas.classList.remove('dragging');
  };
  canvas.addEventListener('pointerup', end);
  canvas.addEventListener('pointercancel', end);
  canvas.addEventListener('contextmenu', (event) => event.preventDefault());

  canvas.addEventListener('wheel', (event) => {
    event.preventDefault();
    // Shift turns the wheel sideways in some browsers.
    const lines = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 33 : event.deltaMode === WheelEvent.DOM_DELTA_PAGE ? 300 : 1;
    const pixels = (event.deltaY || event.deltaX) * lines;
    const dragged = holding()[0]?.role, tool = dragged?.kind === 'tool' ? dragged.tool : event.shiftKey ? gestures.lastTool : null;
    if (tool !== null) gestures.away(tool, -0.1 * pixels);
    else gestures.zoom(Math.exp(0.0015 * pixels));
  }, { passive: false });
}
