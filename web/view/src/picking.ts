// Which point of a surface a ray meets.
import { BufferAttribute, BufferGeometry, DoubleSide, Mesh, MeshBasicMaterial, Raycaster, Vector3 } from 'three';
import type { Ray } from '../../shared/src/camera.js';
import { add, row, scale, type V3 } from '../../shared/src/vectors.js';

export interface Hit {
  /** number of the triangle */
  readonly triangle: number;
  /** barycentric weights of its corners */
  readonly weights: V3;
}

/** The nearest triangle before the origin, seen from either side; null: none. */
export function hitOf({ origin, direction }: Ray, positions: Float32Array, triangles: Int32Array): Hit | null {
  const geometry = new BufferGeometry().setAttribute('position', new BufferAttribute(positions, 3));
  const body = new Mesh(geometry.setIndex(new BufferAttribute(triangles, 1)), new MeshBasicMaterial({ side: DoubleSide }));
  const [hit] = new Raycaster(new Vector3(...origin), new Vector3(...direction)).intersectObject(body);
  return hit ? { triangle: hit.faceIndex!, weights: hit.barycoord!.toArray() } : null;
}

/** The point of a hit on the same triangles with other positions, for example at rest. */
export function pointOf({ triangle, weights }: Hit, positions: ArrayLike<number>, triangles: ArrayLike<number>): V3 {
  let point: V3 = [0, 0, 0];
  for (let k = 0; k < 3; ++k) point = add(point, scale(weights[k]!, row(positions, triangles[3 * triangle + k]!)));
  return point;
}
