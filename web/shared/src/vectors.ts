// Vectors with three components.

export type V3 = readonly [number, number, number];
export const zero: V3 = [0, 0, 0];

export const add = (a: V3, b: V3): V3 => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
export const sub = (a: V3, b: V3): V3 => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const scale = (s: number, a: V3): V3 => [s * a[0], s * a[1], s * a[2]];
export const dot = (a: V3, b: V3): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const norm = (a: V3): number => Math.hypot(a[0], a[1], a[2]);
export const cross = (a: V3, b: V3): V3 => [
  a[1] * b[2] - a[2] * b[1],
  a[2] * b[0] - a[0] * b[2],
  a[0] * b[1] - a[1] * b[0],
];

/** a / |a|; the vector `otherwise` where a is 0. */
export function unit(a: V3, otherwise: V3 = [0, 0, 1]): V3 {
  const size = norm(a);
  return size > 0 ? scale(1 / size, a) : otherwise;
}

/** a, shortened to the length `most` if it is longer. */
export function shortened(a: V3, most: number): V3 {
  const size = norm(a);
  return size > most ? scale(most / size, a) : a;
}

/** Row i of an n x 3 array. */
export const row = (rows: ArrayLike<number>, i: number): V3 => [rows[3 * i]!, rows[3 * i + 1]!, rows[3 * i + 2]!];

export const vector = (a: ArrayLike<number>): V3 => row(a, 0);
