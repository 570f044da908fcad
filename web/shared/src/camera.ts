// A camera that turns about a target, z upwards. No graphics: what lies where on the screen is computed here only.
import { add, cross, dot, norm, row, scale, sub, unit, zero, type V3 } from './vectors.js';

export interface Camera {
  readonly target: V3;
  /** of the eye from the target [m] */
  readonly distance: number;
  /** of the eye about the z axis, from the x axis [rad] */
  readonly azimuth: number;
  /** of the eye above the xy plane [rad] */
  readonly elevation: number;
}

/** Size of the picture in CSS pixels. */
export interface Size {
  readonly width: number;
  readonly height: number;
}

/** Vertical angle of view [rad]. */
export const angleOfView = (30 * Math.PI) / 180;
const steepest = (89 * Math.PI) / 180;

export interface Frame {
  readonly eye: V3;
  readonly right: V3;
  readonly up: V3;
  /** from the eye to the target */
  readonly forward: V3;
}

export function frameOf({ target, distance, azimuth, elevation }: Camera): Frame {
  const back: V3 = [
    Math.cos(elevation) * Math.cos(azimuth),
    Math.cos(elevation) * Math.sin(azimuth),
    Math.sin(elevation),
  ];
  const right: V3 = [-Math.sin(azimuth), Math.cos(azimuth), 0];
  return { eye: add(target, scale(distance, back)), right, up: cross(back, right), forward: scale(-1, back) };
}

/** Pixels per metre at a distance of 1 m before the eye. */
const focus = (size: Size): number => size.height / (2 * Math.tan(angleOfView / 2));

export interface Projected {
  /** pixels from the left and from the top */
  readonly x: number;
  readonly y: number;
  /** before the eye [m]; negative behind it */
  readonly depth: number;
}

export function project(camera: Camera, size: Size, point: V3): Projected {
  const { eye, right, up, forward } = frameOf(camera);
  const from = sub(point, eye), depth = dot(from, forward), f = focus(size) / depth;
  return { x: size.width / 2 + f * dot(from, right), y: size.height / 2 - f * dot(from, up), depth };
}

export interface Ray {
  readonly origin: V3;
  /** unit vector */
  readonly direction: V3;
}

export function rayThrough(camera: Camera, size: Size, x: number, y: number): Ray {
  const { eye, right, up, forward } = frameOf(camera), f = focus(size);
  const across = add(scale((x - size.width / 2) / f, right), scale((size.height / 2 - y) / f, up));
  return { origin: eye, direction: unit(add(forward, across)) };
}

/** Length of a pixel at a depth [m]. */
export const metresPerPixel = (size: Size, depth: number): number => depth / focus(size);

/** Movement of a point at `depth` that follows the pointer by dx, dy pixels, parallel to the screen [m]. */
export function acrossScreen(camera: Camera, size: Size, depth: number, dx: number, dy: number): V3 {
  const { right, up } = frameOf(camera), metres = metresPerPixel(size, depth);
  return add(scale(dx * metres, right), scale(-dy * metres, up));
}

export function turned(camera: Camera, byAzimuth: number, byElevation: number): Camera {
  const elevation = Math.min(steepest, Math.max(-steepest, camera.elevation + byElevation));
  const azimuth = camera.azimuth + byAzimuth;
  return { ...camera, elevation, azimuth: azimuth - 2 * Math.PI * Math.round(azimuth / (2 * Math.PI)) };
}

/** Closer by a factor below 1, further by a factor above 1, in the limits that are useful for a body of this radius. */
export function moved(camera: Camera, factor: number, radius: number): Camera {
  return { ...camera, distance: Math.min(20 * radius, Math.max(0.3 * radius, camera.distance * factor)) };
}

/** The target follows the pointer by dx, dy pixels. */
export function shifted(camera: Camera, size: Size, dx: number, dy: number): Camera {
  return { ...camera, target: sub(camera.target, acrossScreen(camera, size, camera.distance, dx, dy)) };
}

export interface Bounds {
  readonly center: V3;
  /** of a sphere around all points [m], > 0 */
  readonly radius: number;
}

export function boundsOf(points: ArrayLike<number>): Bounds {
  let low: V3 = [Infinity, Infinity, Infinity], high: V3 = [-Infinity, -Infinity, -Infinity];
  const n = points.length / 3;
  if (n === 0) return { center: zero, radius: 1 };
  for (let i = 0; i < n; ++i) {
    const p = row(points, i);
    low = [Math.min(low[0], p[0]), Math.min(low[1], p[1]), Math.min(low[2], p[2])];
    high = [Math.max(high[0], p[0]), Math.max(high[1], p[1]), Math.max(high[2], p[2])];
  }
  const center = scale(0.5, add(low, high));
  let radius = 0;
  for (let i = 0; i < n; ++i) radius = Math.max(radius, norm(sub(row(points, i), center)));
  return { center, radius: radius || 1 };
}

/** The camera with its eye at least `least` from every point that is near its line of sight, or behind it [m]. */
export function outsideOf(camera: Camera, points: ArrayLike<number>, least: number): Camera {
  const back = scale(-1, frameOf(camera).forward);
  let { distance } = camera;
  for (let i = 0; i < points.length; i += 3) {
    const from = sub(row(points, i / 3), camera.target), along = dot(from, back), across2 = dot(from, from) - along * along;
    if (across2 < least * least) distance = Math.max(distance, along + Math.sqrt(least * least - across2));
  }
  return distance > camera.distance ? { ...camera, distance } : camera;
}

const fromFront = { azimuth: (-65 * Math.PI) / 180, elevation: (32 * Math.PI) / 180 };

/** From where most of some points are seen: the front and above, unless they lie on the other side of the body. */
export function facing(body: ArrayLike<number>, points: readonly V3[]): { azimuth: number; elevation: number } {
  const { center, radius } = boundsOf(body), sum = points.reduce((a, b) => add(a, sub(b, center)), zero);
  const [x, y, z] = scale(1 / (points.length * radius), sum);
  if (!(dot([x, y, z], frameOf({ target: zero, distance: 1, ...fromFront }).eye) < -0.1)) return fromFront;
  return { azimuth: Math.atan2(y, x), elevation: Math.atan2(z, Math.hypot(x, y)) };
}

/** The whole body, from the front and above or from where another camera is, as large as the picture allows with a margin for
 * legends. */
export function framing(points: ArrayLike<number>, size: Size, { azimuth, elevation }: { azimuth: number; elevation: number } = fromFront): Camera {
  const { center, radius } = boundsOf(points);
  let camera: Camera = { target: center, distance: (2 * radius) / Math.tan(angleOfView / 2), azimuth, elevation };
  for (let pass = 0; pass < 4; ++pass) {
    let left = Infinity, right = -Infinity, top = Infinity, bottom = -Infinity;
    for (let i = 0; i < points.length / 3; ++i) {
      const { x, y } = project(camera, size, row(points, i));
      left = Math.min(left, x); right = Math.max(right, x);
      top = Math.min(top, y); bottom = Math.max(bottom, y);
    }
    if (!(right > left) && !(bottom > top)) break;
    const centred = shifted(camera, size, size.width / 2 - (left + right) / 2, size.height / 2 - (top + bottom) / 2);
    const filled = Math.max((right - left) / (0.84 * size.width), (bottom - top) / (0.66 * size.height));
    camera = { ...centred, distance: camera.distance * filled };
  }
  return camera;
}
