// Inward directions from another definition than the page's: where the volume inside the surface decreases fastest.
import { cross, dot, row, unit, type V3 } from '../shared/src/vectors.js';

/** Surface: points n x 3, triangles m x 3; outward. @param i  row of a point */
export function inwardAt(points: ArrayLike<number>, triangles: ArrayLike<number>, i: number): V3 {
  const volume = (shift: V3): number => {
    const at = (k: number): V3 => row(points, k).map((x, c) => x + (k === i ? shift[c]! : 0)) as unknown as V3;
    let sum = 0;
    for (let t = 0; t < triangles.length; t += 3) sum += dot(at(triangles[t]!), cross(at(triangles[t + 1]!), at(triangles[t + 2]!)));
    return sum;
  };
  // Exact: the volume is linear in each point.
  return unit(([[1, 0, 0], [0, 1, 0], [0, 0, 1]] as const).map((axis) => volume([0, 0, 0]) - volume(axis)) as unknown as V3);
}
