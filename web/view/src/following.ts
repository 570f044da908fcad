// Loop's scheme smooths displacements, so that the drawn surface would lag behind a tool. The picture therefore gets a field
// that is changed at the held nodes only, by as much as the drawn surface needs to follow the tools exactly.
import { sub, type V3 } from '../../shared/src/vectors.js';
import type { Place } from './places.js';

export interface Follower {
  readonly place: Place;
  /** of the held point [m] */
  readonly displacement: V3;
}
interface Deforming {
  deform(field: Float64Array): Float32Array;
}

/** Displacement of a place of the drawn surface: its vertices have the rows of the nodes. */
export function drawnAt(vertices: ArrayLike<number>, { nodes, weights }: Place, rows: ReadonlyMap<number, number>): V3 {
  const sum: [number, number, number] = [0, 0, 0];
  nodes.forEach((node, i) => {
    const row = rows.get(node)!;
    for (let k = 0; k < 3; ++k) sum[k]! += weights[i]! * vertices[3 * row + k]!;
  });
  return sum;
}

/** How far the drawn place `a` moves when the nodes of `b` move by 1 times their weights. */
export class Influence {
  private readonly known = new Map<string, Float32Array>();

  constructor(
    private readonly surface: Deforming,
    private readonly rows: ReadonlyMap<number, number>,
    private readonly nOutput: number,
  ) {}

  of(a: Place, b: Place): number {
    const key = JSON.stringify(b);
    let response = this.known.get(key);
    if (!response) {
      const field = new Float64Array(3 * this.nOutput);
      b.nodes.forEach((node, i) => {
        const row = this.rows.get(node)!;
        if (row < this.nOutput) field[3 * row] = b.weights[i]!;
      });
      response = this.surface.deform(field);
      if (this.known.size > 16) this.known.clear();
      this.known.set(key, response);
    }
    return drawnAt(response, a, this.rows)[0];
  }
  /** `field` with changes at the held nodes, such that the drawn surface follows. @param drawn  surface under `field` */
  followed(field: Float64Array, drawn: ArrayLike<number>, tools: readonly Follower[]): Float64Array {
    const gaps = tools.map(({ place, displacement }) => sub(displacement, drawnAt(drawn, place, this.rows)));
    const changes = solved(tools.map((a) => tools.map((b) => this.of(a.place, b.place))), gaps);
    if (!changes) return field;
    const out = field.slice();
    tools.forEach(({ place: { nodes, weights } }, t) => nodes.forEach((node, i) => {
      const row = this.rows.get(node)!;
      if (row < this.nOutput) for (let k = 0; k < 3; ++k) out[3 * row + k]! += weights[i]! * changes[t]![k]!;
    }));
    return out;
  }
}

/** One or two equations with a vector each; null where they are close to singular. */
function solved(a: readonly (readonly number[])[], b: readonly V3[]): V3[] | null {
  if (b.length === 1) {
    const w = a[0]![0]!;
    return w > 0.05 ? [[b[0]![0] / w, b[0]![1] / w, b[0]![2] / w]] : null;
  }
  if (b.length !== 2) return null;
  const [[p, q], [r, s]] = a as unknown as [[number, number], [number, number]], d = p * s - q * r;
  if (d < 0.01) return null;
  const [x, y] = b as [V3, V3];
  return [
    [0, 1, 2].map((k) => (s * x[k]! - q * y[k]!) / d) as unknown as V3,
    [0, 1, 2].map((k) => (p * y[k]! - r * x[k]!) / d) as unknown as V3,
  ];
}
