// Principal directions of a symmetric 3 x 3 matrix.
import type { V3 } from '../../shared/src/vectors.js';

export interface Principal {
  /** ascending */
  readonly values: V3;
  /** unit vectors of the values */
  readonly directions: readonly [V3, V3, V3];
}

/** Jacobi's method, accurate to rounding. @param matrix  9 numbers; its symmetric part is used */
export function principalOf(matrix: ArrayLike<number>): Principal {
  const a = [0, 1, 2].map((i) => [0, 1, 2].map((j) => 0.5 * (matrix[3 * i + j]! + matrix[3 * j + i]!)));
  const v = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
  for (let sweep = 0; sweep < 30; ++sweep) {
    const size = Math.hypot(...a.flat());
    if (Math.hypot(a[0]![1]!, a[0]![2]!, a[1]![2]!) <= 1e-15 * size) break;
    for (const [p, q] of [[0, 1], [0, 2], [1, 2]] as const) rotate(a, v, p, q);
  }
  const order = [0, 1, 2].sort((i, j) => a[i]![i]! - a[j]![j]!);
  const direction = (k: number): V3 => [v[0]![k]!, v[1]![k]!, v[2]![k]!];
  return {
    values: order.map((k) => a[k]![k]!) as unknown as V3,
    directions: order.map(direction) as unknown as [V3, V3, V3],
  };
}

/** Makes a[p][q] zero by a rotation; v collects the rotations. */
function rotate(a: number[][], v: number[][], p: number, q: number): void {
  if (a[p]![q] === 0) return;
  const theta = (a[q]![q]! - a[p]![p]!) / (2 * a[p]![q]!);
  const t = (theta >= 0 ? 1 : -1) / (Math.abs(theta) + Math.hypot(theta, 1)), c = 1 / Math.hypot(t, 1), s = t * c;
  for (let k = 0; k < 3; ++k) {
    const x = a[k]![p]!, y = a[k]![q]!;
    a[k]![p] = c * x - s * y;
    a[k]![q] = s * x + c * y;
  }
  for (let k = 0; k < 3; ++k) {
    const x = a[p]![k]!, y = a[q]![k]!;
    a[p]![k] = c * x - s * y;
    a[q]![k] = s * x + c * y;
    const vx = v[k]![p]!, vy = v[k]![q]!;
    v[k]![p] = c * vx - s * vy;
    v[k]![q] = s * vx + c * vy;
  }
}
