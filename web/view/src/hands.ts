// Gestures and keys, translated into movements of tools and of the camera.
import { acrossScreen, frameOf, metresPerPixel, moved, project, rayThrough, shifted, turned } from '../../shared/src/camera.js';
import { add, dot, norm, row, scale, sub, zero, type V3 } from '../../shared/src/vectors.js';
import { hitOf, pointOf } from './picking.js';
import { mainNode, nameOf, placeAt } from './places.js';
import type { Gestures } from './pointer.js';
import { sphereTool } from './session.js';
import type { View } from './view.js';

/** A tool nearer than this to the pointer is taken [pixels]. */
const near = 22;

export class Hands implements Gestures {
  /** positions of dragged tools where they were grabbed, moved by the wheel */
  private readonly from = new Map<number, V3>();
  private readonly sideways = new Map<number, readonly [number, number]>();

  constructor(private readonly sight: View) {}

  // ---- pointers ---------------------------------------------------------------------------------------------------

  grab(x: number, y: number, more: boolean): number | null {
    const { session } = this.sight, number = session.state.mode === 'sphere' ? this.grabSphere(x, y, more) : this.grabPoint(x, y, more);
    if (number === null) return null;
    this.from.set(number, session.positionOf(number));
    this.sideways.set(number, [0, 0]);
    this.sight.changed(true);
    return number;
  }
  private grabPoint(x: number, y: number, more: boolean): number | null {
    const { session, camera, size, positions, rest, triangles } = this.sight;
    const { tools } = session.state;
    const at = tools.findIndex((tool) => {
      const seen = project(camera, size, this.sight.seen(tool));
      return Math.hypot(seen.x - x, seen.y - y) < near && !this.from.has(session.numberOf(tools.indexOf(tool)));
    });
    if (at >= 0) return session.numberOf(at);
    const hit = hitOf(rayThrough(camera, size, x, y), positions, triangles);
    if (!hit) return null;
    const place = session.placeNear(pointOf(hit, rest, triangles));
    if (!place) {
      this.sight.say('This part of the body was not trained and cannot be held.');
      return null;
    }
    if (more && session.state.most < 2) session.state.most = 2;
    return session.hold(place, [...this.from.keys()]);
  }
  private grabSphere(x: number, y: number, more: boolean): number | null {
    const { session, camera, size, positions, rest, triangles } = this.sight, { center, radius } = session.state.sphere;
    if (more) return null;
    const ray = rayThrough(camera, size, x, y);
    if (center) {
      const to = sub(center, ray.origin), along = dot(to, ray.direction);
      if (norm(sub(to, scale(along, ray.direction))) < radius) return sphereTool;
    }
    const hit = hitOf(ray, positions, triangles);
    if (!hit) return null;
    const i = triangles[3 * hit.triangle]!, j = triangles[3 * hit.triangle + 1]!, k = triangles[3 * hit.triangle + 2]!;
    const u = sub(row(rest, j), row(rest, i)), v = sub(row(rest, k), row(rest, i));
    const normal: V3 = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    session.putSphere(pointOf(hit, rest, triangles), scale(1 / (norm(normal) || 1), normal));
    return sphereTool;
  }

  across(tool: number, dx: number, dy: number): void {
    this.sideways.set(tool, [dx, dy]);
    this.follow(tool);
  }
  away(tool: number, pixels: number): void {
    const { camera, size, session } = this.sight;
    const metres = pixels * metresPerPixel(size, camera.distance);
    const along = scale(metres, frameOf(camera).forward);
    const from = this.from.get(tool);
    if (from) {
      this.from.set(tool, add(from, along));
      this.follow(tool);
    } else {
      session.move(tool, add(session.positionOf(tool), along));
      this.sight.changed(true);
    }
  }
  private follow(tool: number): void {
    const { camera, size, session } = this.sight, from = this.from.get(tool), [dx, dy] = this.sideways.get(tool) ?? [0, 0];
    if (!from) return;
    const held = session.toolOf(tool), start = held ? add(session.restPoint(held.place), from) : from;
    session.move(tool, add(from, acrossScreen(camera, size, project(camera, size, start).depth, dx, dy)));
    this.sight.changed(true);
  }
  release(tool: number): void {
    this.from.delete(tool);
    this.sideways.delete(tool);
    const { session } = this.sight;
    if (tool !== sphereTool && !session.state.keep) {
      session.letGo(tool);
      this.sight.changed(true);
    }
    this.sight.say(this.told());
  }
  turn(dx: number, dy: number): void {
    this.sight.camera = turned(this.sight.camera, -0.008 * dx, 0.008 * dy);
    this.sight.changed(false);
  }
  shift(dx: number, dy: number): void {
    this.sight.camera = shifted(this.sight.camera, this.sight.size, dx, dy);
    this.sight.changed(false);
  }
  zoom(factor: number): void {
    this.sight.camera = moved(this.sight.camera, factor, this.sight.session.bounds.radius);
    this.sight.changed(false);
  }
  get lastTool(): number | null {
    return this.sight.session.lastNumber;
  }

  // ---- keys and buttons -------------------------------------------------------------------------------------------

  nextNode(by: 1 | -1): void {
    const { session } = this.sight, active = session.runtime.model.info.activeNodes;
    const { tools, most } = session.state;
    // A node that is held by the keyboard is let go, unless a second tool may join it.
    if (session.state.mode !== 'hold' || active.length === 0) return;
    if (tools.length >= most && session.lastNumber !== null) session.letGo(session.lastNumber);
    const i = active.indexOf(session.cursor);
    session.cursor = active[(i + by + active.length) % active.length]!;
    this.sight.changed(true);
    this.sight.say(`Node ${session.cursor}`);
  }
  /** The tool of the keyboard; the node of the cursor is held if it is free. */
  private tool(): number {
    const { session } = this.sight, { state } = session;
    if (state.mode === 'sphere') return sphereTool;
    const last = session.lastNumber, held = last === null ? null : session.toolOf(last);
    if (held && (state.tools.length >= state.most || mainNode(held.place) === session.cursor)) return last!;
    return session.hold(placeAt(session.cursor));
  }
  private by(move: V3): void {
    const { session } = this.sight, tool = this.tool();
    session.move(tool, add(session.positionOf(tool), move));
    this.sight.changed(true);
    this.sight.say(this.told());
  }
  /** right, up, away from the viewer; in steps */
  move(steps: V3): void {
    const { camera, step } = this.sight, { right, up, forward } = frameOf(camera);
    this.by(add(add(scale(steps[0] * step, right), scale(steps[1] * step, up)), scale(steps[2] * step, forward)));
  }
  /** into the body: 1, out of it: -1 */
  press(steps: number): void {
    const { session, step } = this.sight, tool = session.toolOf(this.tool());
    const normal = tool ? session.normalAt(tool.place) : scale(-1, frameOf(this.sight.camera).forward);
    this.by(scale(-steps * step, normal));
  }
  pin(): void {
    const { session } = this.sight;
    if (session.state.mode !== 'hold') return;
    session.state.most = 2;
    this.sight.changed(true);
    this.sight.say(session.state.tools.length > 0 ? 'Pinned. Choose another node and move it.' : 'Two tools');
  }
  letGo(): void {
    this.sight.session.letGoAll();
    this.sight.changed(true);
    this.sight.say('Let go');
  }
  otherMode(): void {
    const { session } = this.sight;
    session.setMode(session.state.mode === 'hold' ? 'sphere' : 'hold');
    this.sight.changed(true);
    this.sight.say(session.state.mode === 'hold' ? 'Tools hold the body' : 'A sphere touches the body');
  }
  /** Place, displacement and force of the last tool in words. */
  private told(): string {
    const { session } = this.sight, { state } = session;
    session.update();
    const force = norm(session.answer.forces[session.answer.forces.length - 1] ?? zero).toPrecision(3);
    if (state.mode === 'sphere') return session.answer.touches[0]?.inContact ? `In contact, ${force} newtons` : 'No contact';
    const tool = state.tools[state.tools.length - 1];
    return tool ? `${nameOf(tool.place)}, ${(1e3 * norm(tool.displacement)).toPrecision(3)} millimetres, ${force} newtons` : 'Let go';
  }
}
