// Which point of a surface a ray meets.
import type { Ray } from '../../shared/src/camera.js';
import { add, row, scale, type V3 } from '../../shared/src/vectors.js';

export interface Hit {
  /** number of the triangle */
  readonly triangle: number;
  /** barycentric weights of its corners */
  readonly weights: V3;
  /** from the origin of the ray [m] */
  readonly distance: number;
}

/** The nearest triangle before the origin, seen from either side; null: none. */
export function hitOf({ origin, direction }: Ray, positions: ArrayLike<number>, triangles: ArrayLike<number>): Hit | null {
  let best: Hit | null = null, nearest = Infinity;
  const [dx, dy, dz] = direction;
  for (let t = 0; t < triangles.length; t += 3) {
    const a = 3 * triangles[t]!, b = 3 * triangles[t + 1]!, c = 3 * triangles[t + 2]!;
    const ax = positions[a]!, ay = positions[a + 1]!, az = positions[a + 2]!;
    const ux = positions[b]! - ax, uy = positions[b + 1]! - ay, uz = positions[b + 2]! - az;
    const vx = positions[c]! - ax, vy = positions[c + 1]! - ay, vz = positions[c + 2]! - az;
    const px = dy * vz - dz * vy, py = dz * vx - dx * vz, pz = dx * vy - dy * vx;
    const determinant = ux * px + uy * py + uz * pz;
    if (determinant === 0) continue;
    const sx = origin[0] - ax, sy = origin[1] - ay, sz = origin[2] - az;
    const s = (sx * px + sy * py + sz * pz) / determinant;
    if (s < 0 || s > 1) continue;
    const qx = sy * uz - sz * uy, qy = sz * ux - sx * uz, qz = sx * uy - sy * ux;
    const r = (dx * qx + dy * qy + dz * qz) / determinant;
    if (r < 0 || s + r > 1) continue;
    const distance = (vx * qx + vy * qy + vz * qz) / determinant;
    if (distance > 0 && distance < nearest) {
      nearest = distance;
      best = { triangle: t / 3, weights: [1 - s - r, s, r], distance };
    }
  }
  return best;
}

/** The point of a hit on the same triangles with other positions, for example at rest. */
export function pointOf({ triangle, weights }: Hit, positions: ArrayLike<number>, triangles: ArrayLike<number>): V3 {
  let point: V3 = [0, 0, 0];
  for (let k = 0; k < 3; ++k) point = add(point, scale(weights[k]!, row(positions, triangles[3 * triangle + k]!)));
  return point;
}
