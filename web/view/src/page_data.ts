// The data that `phynness view` writes into the page (cli/view_command.cpp, which has checked them).
import { dot, unit, type V3 } from '../../shared/src/vectors.js';

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
  readonly model: string | null;
  /** text of a reduced body */
  readonly body: string | null;
  readonly scene_title: string;
  readonly validation: NodeErrors | null;
  readonly rays: readonly StoredRay[];
}

/** @param json  the text of the element `phynness-data` */
export function pageDataOf(json: string): PageData {
  return { model: null, body: null, scene_title: '', validation: null, rays: [], ...(JSON.parse(json) as Partial<PageData>) };
}

/** The stored ray of the node whose direction is nearest to d, and the angle between them [rad]. */
export function nearestRay(rays: readonly StoredRay[], node: number, d: V3): { ray: StoredRay; angle: number } | null {
  let best: { ray: StoredRay; angle: number } | null = null;
  for (const ray of rays) {
    if (ray.node !== node) continue;
    const angle = Math.acos(Math.min(1, Math.max(-1, dot(ray.direction, unit(d)))));
    if (!best || angle < best.angle) best = { ray, angle };
  }
  return best;
}
