// The data that `phynness view` writes into the page. Whatever is malformed is left out; the page works without it.
import type { V3 } from '../../shared/src/vectors.js';

/** Finite element increments of one probed direction of a node. */
export interface StoredRay {
  readonly node: number;
  /** unit vector */
  readonly direction: V3;
  /** ascending [m] */
  readonly depths: readonly number[];
  /** on the object [N] */
  readonly forces: readonly V3[];
}
export interface NodeErrors {
  readonly nodes: readonly number[];
  /** fractions */
  readonly force: readonly number[];
  readonly displacement: readonly number[];
}
export interface PageData {
  readonly model: string | null;
  /** text of a reduced body */
  readonly body: string | null;
  readonly sceneTitle: string;
  readonly validation: NodeErrors | null;
  readonly rays: readonly StoredRay[];
}

const object = (x: unknown): Record<string, unknown> | null =>
  typeof x === 'object' && x !== null && !Array.isArray(x) ? (x as Record<string, unknown>) : null;
const text = (x: unknown): string => (typeof x === 'string' ? x : '');
const numbers = (x: unknown): number[] | null =>
  Array.isArray(x) && x.every((n) => typeof n === 'number' && Number.isFinite(n)) ? (x as number[]) : null;
const isNode = (x: unknown): x is number => Number.isInteger(x) && (x as number) >= 0;

function vectorOf(x: unknown): V3 | null {
  const v = numbers(x);
  return v && v.length === 3 ? [v[0]!, v[1]!, v[2]!] : null;
}

function rayOf(x: unknown): StoredRay | null {
  const ray = object(x), direction = vectorOf(ray?.['direction']), depths = numbers(ray?.['depth_m']);
  if (!ray || !isNode(ray['node']) || !direction || !depths || !Array.isArray(ray['force_N'])) return null;
  const forces = ray['force_N'].map(vectorOf);
  if (forces.length !== depths.length || forces.includes(null)) return null;
  return { node: ray['node'], direction, depths, forces: forces as V3[] };
}

function errorsOf(x: unknown): NodeErrors | null {
  const errors = object(x), nodes = numbers(errors?.['nodes']), force = numbers(errors?.['force_error']);
  const displacement = numbers(errors?.['displacement_error']);
  if (!nodes || !force || nodes.length === 0 || force.length !== nodes.length || !nodes.every(isNode)) return null;
  return { nodes, force, displacement: displacement?.length === nodes.length ? displacement : [] };
}

/** @param json  the text of the element `phynness-data` */
export function pageDataOf(json: string): PageData {
  let page: Record<string, unknown> = {};
  try {
    page = object(JSON.parse(json)) ?? {};
  } catch {
    // The page then asks for a model.
  }
  const rays = Array.isArray(page['rays']) ? page['rays'].map(rayOf).filter((ray) => ray !== null) : [];
  return {
    model: typeof page['model'] === 'string' ? page['model'] : null,
    body: typeof page['body'] === 'string' ? page['body'] : null,
    sceneTitle: text(page['scene_title']),
    validation: errorsOf(page['validation']),
    rays,
  };
}

/** The stored ray of the node whose direction is nearest to d, and the angle between them [rad]. */
export function nearestRay(rays: readonly StoredRay[], node: number, d: V3): { ray: StoredRay; angle: number } | null {
  const size = Math.hypot(...d);
  let best: { ray: StoredRay; angle: number } | null = null, most = -Infinity;
  for (const ray of rays) {
    if (ray.node !== node) continue;
    const length = Math.hypot(...ray.direction) || 1;
    const cosine = size > 0 ? (ray.direction[0] * d[0] + ray.direction[1] * d[1] + ray.direction[2] * d[2]) / (size * length) : 0;
    if (cosine > most) {
      most = cosine;
      best = { ray, angle: size > 0 ? Math.acos(Math.min(1, Math.max(-1, cosine))) : 0 };
    }
  }
  return best;
}
