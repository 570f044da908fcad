// The data that `phynness view` writes into the page (cli/view_command.cpp, which has checked them).
import { dot, scale, type V3 } from '../../shared/src/vectors.js';

/** Finite element increments of one probed direction of a node. */
export interface StoredRay {
  readonly node: number;
  /** unit vector */
  readonly direction: V3;
  /** ascending */
  readonly depth_m: readonly number[];
  /** on the object */
  readonly force_N: readonly V3[];
}
/** Fractions, by node. */
export interface NodeErrors {
  readonly nodes: readonly number[];
  readonly force_error: readonly number[];
  readonly displacement_error: readonly number[];
}
export interface PageData {
  readonly model: string;
  /** text of a reduced body */
  readonly body: string | null;
  readonly validation: NodeErrors | null;
  readonly rays: readonly StoredRay[];
}

/** @param json  the text of the element `phynness-data` */
export function pageDataOf(json: string): PageData {
  return { model: '', body: null, validation: null, rays: [], ...(JSON.parse(json) as Partial<PageData>) };
}

/** The stored ray of a node whose direction is nearest to d; null: it has none. */
export function nearestRay(rays: readonly StoredRay[], node: number, d: V3): StoredRay | null {
  const along = (ray: StoredRay) => dot(ray.direction, d);
  return rays.reduce<StoredRay | null>((best, ray) => (ray.node === node && (!best || along(ray) > along(best)) ? ray : best), null);
}

/** d, turned into the nearest stored direction of a node and as long as its part in that direction. */
export function alongRay(rays: readonly StoredRay[], node: number, d: V3): V3 {
  const ray = nearestRay(rays, node, d);
  return ray ? scale(Math.max(0, dot(ray.direction, d)), ray.direction) : d;
}
