// Quantities that can be shown as colours on the surface: a value for each output node, and where it is known.
import type { Scale } from '../../shared/src/legend.js';
import { roundedUp } from '../../shared/src/numbers.js';
import { dot, row, scale, unit, type V3 } from '../../shared/src/vectors.js';
import { normalsOf } from '../../shared/src/normals.js';
import type { Runtime } from './answers.js';
import type { NodeErrors } from './page_data.js';
import { nodeOf, placeAt } from './places.js';
import type { HeldTool } from './state.js';

export interface MapValues {
  readonly scale: Scale;
  /** by output node */
  readonly values: Float64Array;
  /** 1 where the value is known, otherwise 0 */
  readonly known: Float64Array;
}
export interface MapKind {
  readonly name: string;
  readonly title: string;
  /** @param tools  what holds the body; null: something else touches it, for which fields are not known */
  values(tools: readonly HeldTool[] | null): MapValues;
}

/** Outward unit normals of the output nodes, n x 3. */
export function outwardNormals(runtime: Runtime): Float32Array {
  const { outputPoints, fixedPoints, triangles } = runtime.model.info;
  const points = Float64Array.from([...outputPoints, ...fixedPoints]);
  return normalsOf(points, triangles, new Float32Array(points.length));
}

/** Secant stiffness against pressing straight in at a node that answers: the force along the inward normal by the depth [N/m]. */
export function palpationStiffness(runtime: Runtime, node: number, normal: V3, depth: number): number {
  const inward = scale(-1, unit(normal));
  return dot(runtime.forceAt(node, scale(depth, inward)), inward) / depth;
}

/** A quarter of the trained depth, at most 5 mm: about what a finger does. */
export const usualPalpationDepth = (runtime: Runtime): number => Math.min(0.005, 0.25 * runtime.model.info.maxDisplacement);

/** The maps of a model. @param palpationDepth  [m] */
export function mapsOf(runtime: Runtime, errors: NodeErrors | null, palpationDepth: () => number): readonly MapKind[] {
  const { activeNodes, outputNodes, fields, maxDisplacement } = runtime.model.info, n = outputNodes.length;
  const normals = outwardNormals(runtime);

  /** A map with values at some nodes. */
  const atNodes = (name: string, title: string, unitName: string, nodes: ArrayLike<number>, value: (node: number, i: number) => number,
    note: string, from0 = true): MapKind => ({
    name, title,
    values() {
      const values = new Float64Array(n), known = new Float64Array(n);
      let low = Infinity, high = -Infinity;
      for (let i = 0; i < nodes.length; ++i) {
        const at = runtime.rows.get(nodes[i]!);
        if (at === undefined || at >= n) continue;
        const x = value(nodes[i]!, i);
        if (!Number.isFinite(x)) continue;
        values[at] = x;
        known[at] = 1;
        low = Math.min(low, x);
        high = Math.max(high, x);
      }
      return { scale: { title, unit: unitName, low: from0 ? 0 : low, high: from0 ? roundedUp(high) : high, note }, values, known };
    },
  });
  /** A map of the present deformation; its scale only grows, so that colours can be compared while dragging. */
  const live = (name: string, title: string, unitName: string, initial: number, fill: (tools: readonly HeldTool[] | null, out: Float64Array) => boolean,
    note: string): MapKind => {
    let high = initial;
    return {
      name, title,
      values(tools) {
        const values = new Float64Array(n), known = new Float64Array(n).fill(fill(tools, values) ? 1 : 0);
        high = Math.max(high, roundedUp(values.reduce((a, b) => Math.max(a, b), 0) || initial));
        return { scale: { title, unit: unitName, low: 0, high: high || 1, ...(known[0] === 1 ? {} : { note }) }, values, known };
      },
    };
  };

  /** Active nodes and, where the model answers tools between them, the others there. */
  const touched = () => outputNodes.filter((node) => runtime.active.has(node) || (!runtime.body && runtime.canHold(placeAt(node))));
  const grey = 'Grey: not trained', unprobed = 'Mean of the probes of a node. Grey: none';
  return [
    atNodes('palpation', 'Stiffness under a finger', 'N/m', touched(),
      (node) => palpationStiffness(runtime, node, row(normals, runtime.rows.get(node)!), palpationDepth()), grey),
    ...(errors && errors.nodes.length > 0 ? [
      atNodes('force-error', 'Error of the force', 'fraction', errors.nodes, (_, i) => errors.force_error[i]!, unprobed),
      atNodes('displacement-error', 'Error of the displacement', 'fraction', errors.nodes, (_, i) => errors.displacement_error[i]!, unprobed),
    ] : []),
    atNodes('trained-depth', 'Depth trained in all directions', 'm', activeNodes, (node) => runtime.model.trainedDepth(node, [0, 0, 0]), grey),
    live('displacement', 'Displacement', 'm', maxDisplacement / 4, (_, out) => {
      for (let i = 0; i < n; ++i) out[i] = Math.hypot(...row(runtime.field, i));
      return true;
    }, ''),
    ...fields.map((field, index) => live(`field:${field.name}`, titleOf(field.name), field.unit, 0, (tools, out) => {
      if (tools?.length === 0) return true;
      const node = tools?.length === 1 ? nodeOf(tools[0]!.place) : null;
      if (!tools || node === null) return false;
      runtime.model.field(node, tools[0]!.displacement, index, out);
      return true;
    }, 'Grey: known for one tool at a node only')),
  ];
}

const titleOf = (name: string): string => {
  const words = name.replaceAll('-', ' ').replace('von mises', 'von Mises');
  return words.charAt(0).toUpperCase() + words.slice(1);
};

/** Values at the vertices of the subdivided surface, which is linear in the values of the nodes. */
export function onSurface(surface: { deform(field: Float64Array): Float32Array }, { values, known, scale: { high } }: MapValues):
  { values: Float32Array; weights: Float32Array } {
  const n = values.length, field = new Float64Array(3 * n), factor = 1 / (high || 1);
  for (let i = 0; i < n; ++i) {
    field[3 * i] = values[i]! * known[i]! * factor;
    field[3 * i + 1] = known[i]!;
  }
  const fine = surface.deform(field), m = fine.length / 3;
  const out = { values: new Float32Array(m), weights: new Float32Array(m) };
  for (let i = 0; i < m; ++i) {
    const weight = fine[3 * i + 1]!;
    out.values[i] = weight > 1e-6 ? fine[3 * i]! / weight / factor : 0;
    // Half known is known: a triangle between known and unknown corners changes in its middle.
    out.weights[i] = Math.min(1, Math.max(0, (weight - 0.25) * 2));
  }
  return out;
}
