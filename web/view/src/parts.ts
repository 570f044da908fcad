// The parts of the surface by how they answer: their colours, and a legend with their shares of the free surface.
import { held, tissue } from '../../shared/src/body_picture.js';
import { cssOf, type Rgb } from '../../shared/src/colour_maps.js';
import { significant } from '../../shared/src/numbers.js';
import { cross, norm, row, sub, type V3 } from '../../shared/src/vectors.js';
import type { Part, Runtime } from './answers.js';

/** In linear light. */
const pale: Rgb = [0.66, 0.42, 0.33];
const colours: Readonly<Record<Part, Rgb>> = { nonlinear: tissue, linear: pale, untouchable: pale, fixed: held };
const words: Readonly<Record<Part, string>> = {
  nonlinear: 'Nonlinear: trained', linear: 'Linear: not trained, no bound', untouchable: 'Not trained: cannot be touched', fixed: 'Fixed',
};

/** Shares of the area that can move, as `phynness info` counts them: a triangle has the part of that corner that answers least;
 * fixed corners answer with the others. */
export function sharesOf({ model, parts }: Runtime): Record<Part, number> {
  const { outputPoints, fixedPoints, triangles } = model.info, points = Float64Array.from([...outputPoints, ...fixedPoints]);
  const areas = { nonlinear: 0, linear: 0, untouchable: 0, fixed: 0 };
  for (let t = 0; t < triangles.length; t += 3) {
    const corners = [0, 1, 2].map((k) => triangles[t + k]!), [a, b, c] = corners.map((i) => row(points, i)) as [V3, V3, V3];
    const part = (['untouchable', 'linear', 'nonlinear', 'fixed'] as const).find((p) => corners.some((i) => parts[i] === p))!;
    areas[part] += norm(cross(sub(b, a), sub(c, a)));
  }
  const free = areas.nonlinear + areas.linear + areas.untouchable || 1;
  return { nonlinear: areas.nonlinear / free, linear: areas.linear / free, untouchable: areas.untouchable / free, fixed: areas.fixed / free };
}

export function partsLegend(runtime: Runtime): HTMLElement {
  const list = document.createElement('ul'), shares = sharesOf(runtime);
  list.className = 'legend parts';
  for (const part of Object.keys(words) as Part[]) {
    if (shares[part] === 0) continue;
    const line = list.appendChild(document.createElement('li')), swatch = line.appendChild(document.createElement('i'));
    swatch.style.background = cssOf(colours[part]);
    line.append(part === 'fixed' ? words[part] : `${words[part]} (${significant(100 * shares[part], 2)} %)`);
  }
  return list;
}

/** Colours of the vertices of a subdivided surface, n x 3, in linear light. */
export function partColours(surface: { deform(field: Float64Array): Float32Array }, { parts, field }: Runtime): Float32Array {
  // The subdivision is linear and gives each vertex the share of a part around it. At the border of the trained part, whose
  // nodes have about 0.7, a triangle is trained if all of its corners are.
  const of = Float64Array.from({ length: field.length }, (_, i) => Number(i % 3 === 0 ? parts[(i - (i % 3)) / 3] === 'nonlinear' : i % 3 === 1));
  const shares = surface.deform(of), out = new Float32Array(shares.length);
  const sharp = (x: number, middle: number) => Math.min(1, Math.max(0, 0.5 + 4 * (x - middle)));
  for (let i = 0; i < out.length; i += 3) {
    const trained = sharp(shares[i]!, 0.7), free = sharp(shares[i + 1]!, 0.5);
    for (let k = 0; k < 3; ++k) out[i + k] = (1 - free) * held[k]! + free * (trained * tissue[k]! + (1 - trained) * pale[k]!);
  }
  return out;
}
