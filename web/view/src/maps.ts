// Quantities that are shown as colours on the surface: a value for each output node, and where it is known.
import type { Scale } from '../../shared/src/legend.js';
import { roundedUp, significant } from '../../shared/src/numbers.js';
import { add, cross, dot, norm, row, scale, sub, unit, vector, zero, type V3 } from '../../shared/src/vectors.js';
import type { HeldPlace, Runtime } from './answers.js';
import type { NodeErrors } from './page_data.js';
import { placeAt } from './places.js';

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
  values(tools: readonly HeldPlace[] | null): MapValues;
}

/** Outward normals of the output nodes: means of their triangles, weighted by area. */
function normalsOf({ outputPoints, fixedPoints, outputNodes, triangles }: Runtime['model']['info']): V3[] {
  const points = Float64Array.from([...outputPoints, ...fixedPoints]), normals = Array.from({ length: points.length / 3 }, () => zero);
  for (let t = 0; t < triangles.length; t += 3) {
    const corners = [0, 1, 2].map((k) => triangles[t + k]!), [a, b, c] = corners.map((i) => row(points, i)) as [V3, V3, V3];
    for (const i of corners) normals[i] = add(normals[i]!, cross(sub(b, a), sub(c, a)));
  }
  return normals.slice(0, outputNodes.length).map((normal) => unit(normal));
}

/** Depths of the pushes [m]: 1 mm, or half of the trained depth where that is less; and 5 mm where the model is trained to it. */
const pushDepths = (trained: number): number[] => [Math.min(1e-3, trained / 2), 5e-3].filter((depth) => depth <= trained);

/** Force along an inward push over its depth [N/m], at every node that can be touched; computed when it is first shown. */
function stiffnessOf({ model, parts }: Runtime, depth: number): MapKind {
  const { outputNodes } = model.info, n = outputNodes.length;
  const title = `Stiffness at ${significant(1e3 * depth, 2).replace(/\.0$/, '')} mm`;
  let map: MapValues | null = null;
  const computed = (): MapValues => {
    const values = new Float64Array(n), known = new Float64Array(n), normals = normalsOf(model.info);
    let low = Infinity, high = 0;
    outputNodes.forEach((node, i) => {
      if (parts[i] !== 'nonlinear' && parts[i] !== 'linear') return;
      const inward = scale(-1, normals[i]!), { force } = model.force(placeAt(node), scale(depth, inward));
      const value = dot(vector(force), inward) / depth;
      values[i] = value;
      known[i] = 1;
      // Beside supports the stiffness is several times larger, so that colours are of the probed part.
      if (parts[i] === 'nonlinear') [low, high] = [Math.min(low, value), Math.max(high, value)];
    });
    const note = `Probed part: ${significant(low, 3)} to ${significant(high, 3)} N/m. Grey: cannot be touched`;
    return { scale: { title, unit: 'N/m', low: Math.min(low, high), high, note }, values, known };
  };
  return { name: `stiffness:${Math.round(1e3 * depth)}`, title, values: () => (map ??= computed()) };
}

/** The maps of a model. */
export function mapsOf(runtime: Runtime, errors: NodeErrors | null): readonly MapKind[] {
  const { outputNodes, fields, maxDisplacement } = runtime.model.info, n = outputNodes.length;

  const ofErrors = (name: string, title: string, by: readonly number[]): MapKind => {
    const values = new Float64Array(n), known = new Float64Array(n);
    errors!.nodes.forEach((node, i) => {
      const at = runtime.rows.get(node) ?? n;
      if (at >= n) return;
      values[at] = by[i]!;
      known[at] = 1;
    });
    const note = 'Mean of the probes of a node. Grey: none', high = roundedUp(Math.max(...by));
    return { name, title, values: () => ({ scale: { title, unit: 'fraction', low: 0, high, note }, values, known }) };
  };
  /** A map of the present deformation; its scale only grows, so that colours can be compared while dragging. */
  const live = (name: string, title: string, unit: string, least: number,
    fill: (tools: readonly HeldPlace[] | null, out: Float64Array) => boolean, note: string): MapKind => {
    let high = least;
    return {
      name, title,
      values(tools) {
        const values = new Float64Array(n), known = new Float64Array(n).fill(fill(tools, values) ? 1 : 0);
        high = Math.max(high, roundedUp(values.reduce((a, b) => Math.max(a, b), 0) || least));
        return { scale: { title, unit, low: 0, high, ...(known[0] === 1 ? {} : { note }) }, values, known };
      },
    };
  };

  return [
    ...(errors && errors.nodes.length > 0 ? [
      ofErrors('force-error', 'Error of the force', errors.force_error),
      ofErrors('displacement-error', 'Error of the displacement', errors.displacement_error),
    ] : []),
    live('displacement', 'Displacement', 'm', maxDisplacement / 4, (_, out) => {
      for (let i = 0; i < n; ++i) out[i] = norm(row(runtime.field, i));
      return true;
    }, ''),
    ...pushDepths(maxDisplacement).map((depth) => stiffnessOf(runtime, depth)),
    ...fields.map((field, index) => live(`field:${field.name}`, titleOf(field.name), field.unit, 0, (tools, out) => {
      if (tools?.length === 0) return true;
      const values = tools?.length === 1 ? runtime.fieldOf(tools[0]!, index) : null;
      if (values) out.set(values);
      return values !== null;
    }, 'Grey: known for one tool only')),
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
