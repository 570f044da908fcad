// Gestures, translated into movements of tools and of the camera.
import { acrossScreen, frameOf, metresPerPixel, moved, project, rayThrough, shifted, turned, type Ray } from '../../shared/src/camera.js';
import { add, cross, dot, norm, row, scale, sub, unit, type V3 } from '../../shared/src/vectors.js';
import { hitOf, pointOf } from './picking.js';
import type { Gestures } from './pointer.js';
import type { Tool } from './session.js';
import type { View } from './view.js';

/** A tool nearer than this to the pointer is taken [pixels]. */
const near = 22;

export class Hands implements Gestures<Tool> {
  /** where tools were grabbed, moved by the wheel, and the way of the pointer since */
  private readonly from = new WeakMap<Tool, { at: V3; dx: number; dy: number }>();

  constructor(private readonly view: View) {}

  grab(x: number, y: number, others: readonly Tool[]): Tool | null {
    const { session, camera, size } = this.view, ray = rayThrough(camera, size, x, y);
    const tool = session.mode === 'sphere' ? this.grabSphere(ray, others) : this.grabPlace(ray, x, y, others);
    if (!tool) return null;
    this.from.set(tool, { at: tool.at, dx: 0, dy: 0 });
    this.view.say('');
    this.view.changed(true);
    return tool;
  }
  private grabPlace(ray: Ray, x: number, y: number, others: readonly Tool[]): Tool | null {
    const { session, camera, size, rest, positions, triangles } = this.view;
    const ball = session.tools.find((tool) => {
      const seen = project(camera, size, this.view.seen(tool));
      return Math.hypot(seen.x - x, seen.y - y) < near && !others.includes(tool);
    });
    const hit = ball ? null : hitOf(ray, positions, triangles);
    if (!hit) return ball ?? null;
    const { place, part } = session.placeNear(pointOf(hit, rest, triangles));
    if (part === 'fixed' || part === 'untouchable') {
      this.view.say(part === 'fixed' ? 'This part is fixed and does not move.' : 'This part was not trained and cannot be touched.');
      return null;
    }
    if (others.length > 0) session.setMost(session.runtime.mostTools);
    return session.hold(place, others);
  }
  private grabSphere(ray: Ray, others: readonly Tool[]): Tool | null {
    const { session, rest, positions, triangles } = this.view, { touches } = session.answer;
    const free = session.tools.filter((tool) => !others.includes(tool)), idle = free.filter((tool) => !touches[session.tools.indexOf(tool)]?.inContact);
    const distance = (tool: Tool, to: V3) => norm(sub(tool.at, to));
    const hitSphere = free.find((tool) => {
      const to = sub(tool.at, ray.origin);
      return norm(sub(to, scale(dot(to, ray.direction), ray.direction))) < session.sphere.radius;
    });
    const hit = hitSphere ? null : hitOf(ray, positions, triangles);
    if (!hit || free.length === 0) return hitSphere ?? null;
    const [a, b, c] = [0, 1, 2].map((k) => row(rest, triangles[3 * hit.triangle + k]!)) as [V3, V3, V3];
    const point = pointOf(hit, rest, triangles);
    const nearest = (idle.length > 0 ? idle : free).reduce((best, tool) => (distance(tool, point) < distance(best, point) ? tool : best));
    session.putSphere(nearest, point, unit(cross(sub(b, a), sub(c, a))));
    return nearest;
  }

  across(tool: Tool, dx: number, dy: number): void {
    Object.assign(this.from.get(tool)!, { dx, dy });
    this.follow(tool);
  }
  away(tool: Tool, pixels: number): void {
    const { camera, size } = this.view, from = this.from.get(tool)!;
    from.at = add(from.at, scale(pixels * metresPerPixel(size, camera.distance), frameOf(camera).forward));
    this.follow(tool);
  }
  private follow(tool: Tool): void {
    const { camera, size, session } = this.view, { at, dx, dy } = this.from.get(tool)!;
    const start = tool.place ? add(session.restPoint(tool.place), at) : at;
    session.move(tool, add(at, acrossScreen(camera, size, project(camera, size, start).depth, dx, dy)));
    this.view.changed(true);
  }
  /** Moves the tool that was moved last away from the viewer, in tenths of the trained depth. */
  push(tenths: number): void {
    const { session, camera } = this.view, tool = session.tools[session.current];
    if (!tool) return;
    session.move(tool, add(tool.at, scale(0.05 * tenths * session.limit, frameOf(camera).forward)));
    this.view.changed(true);
  }

  turn(dx: number, dy: number): void {
    this.view.look(turned(this.view.camera, -0.008 * dx, 0.008 * dy));
  }
  shift(dx: number, dy: number): void {
    this.view.look(shifted(this.view.camera, this.view.size, dx, dy));
  }
  zoom(factor: number): void {
    this.view.look(moved(this.view.camera, factor, this.view.session.bounds.radius));
  }
}
