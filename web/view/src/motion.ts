// Recorded motions: "phynness motion 1", which `phynness eval --motion` and the haptic loop read, too.
import type { V3 } from '../../shared/src/vectors.js';
import { nodeOf, placeAt, placeOf, samePlace, type Place } from './places.js';

export interface Step {
  /** [s] */
  readonly time: number;
  /** of each tool of the motion [m]; null: it does not touch */
  readonly displacements: readonly (V3 | null)[];
  /** [N] on the object; null: not known */
  readonly forces: readonly (V3 | null)[];
}
export interface Motion {
  readonly tools: readonly Place[];
  readonly steps: readonly Step[];
  readonly meshHash: string | null;
}
export interface Held {
  readonly place: Place;
  readonly displacement: V3;
  readonly force: V3;
}

const format = 'phynness motion 1', mostTools = 8, mostSteps = 100_000;

export class Recorder {
  private readonly tools: Place[] = [];
  private readonly steps: { time: number; held: Map<number, Held> }[] = [];

  /** False when the recording is full. */
  add(time: number, held: readonly Held[]): boolean {
    const fresh = held.filter(({ place }) => !this.tools.some((tool) => samePlace(tool, place)));
    if (this.steps.length >= mostSteps || this.tools.length + fresh.length > mostTools) return false;
    this.tools.push(...fresh.map(({ place }) => place));
    this.steps.push({ time, held: new Map(held.map((h) => [this.tools.findIndex((tool) => samePlace(tool, h.place)), h])) });
    return true;
  }
  get length(): number {
    return this.steps.length;
  }
  /** Null if nothing was held. */
  motion(meshHash: string): Motion | null {
    if (this.tools.length === 0 || this.steps.length === 0) return null;
    const begin = this.steps[0]!.time;
    return {
      tools: this.tools,
      meshHash,
      steps: this.steps.map(({ time, held }) => ({
        time: time - begin,
        displacements: this.tools.map((_, t) => held.get(t)?.displacement ?? null),
        forces: this.tools.map((_, t) => held.get(t)?.force ?? null),
      })),
    };
  }
}

export function textOf(motion: Motion): string {
  const tools = motion.tools.map((place) => {
    const node = nodeOf(place);
    return node !== null ? { node } : { nodes: place.nodes, weights: place.weights };
  });
  return `${JSON.stringify({
    format,
    ...(motion.meshHash !== null ? { mesh_hash: motion.meshHash } : {}),
    tools,
    time_s: motion.steps.map((step) => step.time),
    displacement_m: motion.steps.map((step) => step.displacements),
    force_N: motion.steps.map((step) => step.forces),
  })}\n`;
}

/** A file that is not a motion. Its message says why. */
export class MotionError extends Error {}

function rowsOf(x: unknown, key: string, nSteps: number, nTools: number): (V3 | null)[][] {
  const vector = (v: unknown) => Array.isArray(v) && v.length === 3 && v.every((n) => typeof n === 'number' && Number.isFinite(n));
  if (!Array.isArray(x) || x.length !== nSteps) throw new MotionError(`${key} does not have one entry for each of the ${nSteps} times`);
  x.forEach((row: unknown, i) => {
    if (!Array.isArray(row) || row.length !== nTools || !row.every((v) => v === null || vector(v)))
      throw new MotionError(`${key}, step ${i}: not one vector or null for each of the ${nTools} tools`);
  });
  return x as (V3 | null)[][];
}

/** @throws MotionError */
export function motionOf(text: string): Motion {
  let json: Record<string, unknown>;
  try {
    json = JSON.parse(text) as Record<string, unknown>;
  } catch {
    throw new MotionError('the file is not JSON');
  }
  if (typeof json !== 'object' || json === null || json['format'] !== format) throw new MotionError(`"format" is not "${format}"`);
  const given = json['tools'], times = json['time_s'];
  if (!Array.isArray(given) || given.length < 1 || given.length > mostTools) throw new MotionError('"tools" has not 1 to 8 tools');
  const tools = given.map((tool: unknown, i) => {
    const node = (tool as { node?: unknown } | null)?.node;
    const place = Number.isInteger(node) && (node as number) >= 0 ? placeAt(node as number) : placeOf(tool);
    if (!place) throw new MotionError(`tool ${i} has neither "node" nor valid "nodes" and "weights"`);
    return place;
  });
  if (!Array.isArray(times) || times.length < 1 || times.length > 1_000_000 || !times.every((t) => typeof t === 'number' && Number.isFinite(t)))
    throw new MotionError('"time_s" is not a list of times');
  if (times.some((t, i) => i > 0 && t < times[i - 1])) throw new MotionError('"time_s" decreases');
  const displacements = rowsOf(json['displacement_m'], 'displacement_m', times.length, tools.length);
  const forces = json['force_N'] === undefined ? null : rowsOf(json['force_N'], 'force_N', times.length, tools.length);
  return {
    tools,
    meshHash: typeof json['mesh_hash'] === 'string' ? json['mesh_hash'] : null,
    steps: times.map((time: number, i) => ({
      time,
      displacements: displacements[i]!,
      forces: forces ? forces[i]! : tools.map(() => null),
    })),
  };
}

/** Length of the largest difference of two lists of forces, where both are known [N]. */
export function largestDifference(a: readonly Step[], b: readonly Step[]): number {
  let largest = 0;
  a.forEach((step, i) => step.forces.forEach((f, t) => {
    const g = b[i]?.forces[t];
    if (f && g) largest = Math.max(largest, Math.hypot(f[0] - g[0], f[1] - g[1], f[2] - g[2]));
  }));
  return largest;
}

/** The last step that is not later than `time`. */
export function stepAt(steps: readonly Step[], time: number): number {
  let low = 0, high = steps.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (steps[middle]!.time <= time) low = middle;
    else high = middle - 1;
  }
  return low;
}
