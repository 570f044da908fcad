// The figures of the panel.
import { shown, significant } from '../../shared/src/numbers.js';
import { add, dot, norm, scale, vector } from '../../shared/src/vectors.js';
import { byId, setFacts, setText } from './dom.js';
import { nearestRay } from './page_data.js';
import { nameOf, nodeOf } from './places.js';
import { drawn, type PlotData } from './plot.js';
import type { Session } from './session.js';

/** Pieces of the curve. */
const pieces = 40;
/** Smallest noticeable difference of forces. */
const noticeable = 0.1;

const withUnit = (x: number, unitName: string, digits: number): string => {
  const { unit, factor } = shown(unitName, x);
  return `${significant(x * factor, digits)} ${unit}`;
};

/** Significant digits of a force: three, or down to the first digit of the bound of its error. */
export function digitsOf(force: number, bound: number | null): number {
  if (!bound || !force) return 3;
  return Math.min(3, Math.max(1, Math.floor(Math.log10(force)) - Math.floor(Math.log10(bound)) + 1));
}

/** A state that the user should know: the class of its colour, a word, and a sentence. */
type State = readonly ['beyond' | 'fair' | 'good', string, string];

/** The states of the present answer, the gravest first. */
export function statesOf({ answer, tools, mode, limit, runtime, sphere }: Session): State[] {
  const { warnings, forces, bounds, touches } = answer, states: State[] = [];
  const [first] = tools, alone = mode === 'hold' && tools.length === 1;
  if (warnings.includes('unsettled'))
    states.push(['beyond', 'unsettled', 'The tools move faster than the body settles, or are too close together: not every place is held exactly.']);
  if (warnings.includes('near'))
    states.push(['beyond', 'too near', 'The tools are nearer than half a radius: springs join them, and their forces may be off by a third and more.']);
  if (alone && runtime.partAt(first!.place!) === 'linear')
    states.push(['fair', 'linear', 'This place was not trained itself: the force is linear in the displacement, wholly or in part, and its error has no bound.']);
  else if (warnings.includes('outside'))
    states.push(['beyond', 'beyond data', `Deeper than trained${alone ? '' : ', or at a place that was not trained'}: the error has no bound.`]);
  if (mode === 'hold' && tools.some(({ at }) => norm(at) > 0.999 * limit))
    states.push(['fair', 'at its limit', `A tool stops at ${withUnit(limit, 'm', 3)}, twice the largest trained depth.`]);
  const scaled = Math.min(1, ...touches.filter(({ inContact }) => inContact).map((touch) => touch.scale));
  if (scaled < 1)
    states.push(['fair', 'lowered', `The force is lowered to ${significant(100 * scaled, 2)} %, so that ${sphere.grasp ? 'grasping' : 'sliding'} returns no more work than was done.`]);
  if (forces.some((force, i) => (bounds[i] ?? 0) > noticeable * norm(force)))
    states.push(['fair', 'inexact', 'The error of the force may exceed a tenth of it.']);
  if (warnings.includes('incomplete'))
    states.push(['fair', 'incomplete', 'In some directions the data end before the full depth here: the body folds, a cell is crushed, or no solution was found.']);
  return states;
}

export class Readouts {
  private readonly heading = byId('force-heading', HTMLElement);
  private readonly newtons = byId('newtons', HTMLElement);
  private readonly verdict = byId('verdict', HTMLElement);
  private readonly reasons = byId('reasons', HTMLElement);
  private readonly quantities = byId('quantities', HTMLElement);
  private readonly plotNote = byId('plot-note', HTMLElement);
  private readonly plot = byId('plot', HTMLElement);

  show(session: Session): void {
    const { answer: { forces, bounds }, touching, mode, current } = session, force = norm(forces[current] ?? [0, 0, 0]);
    setText(this.heading, forces.length > 1 ? `Force of tool ${current + 1} on the body` : 'Force on the body');
    setText(this.newtons, significant(force, digitsOf(force, bounds[current] ?? null)));
    const states = touching ? statesOf(session) : [], good: State = ['good', 'inside range', 'No warning.'];
    const [kind, word] = states[0] ?? good;
    this.verdict.dataset['kind'] = touching ? kind : 'unknown';
    setText(this.verdict, touching ? word : mode === 'sphere' ? 'no contact' : 'at rest');
    setText(this.reasons, touching ? (states.length > 0 ? states : [good]).map(([, , sentence]) => sentence).join(' ') : 'Nothing touches the body.');
    setFacts(this.quantities, this.facts(session));
  }

  private facts({ answer, tools, mode, runtime, current }: Session): (readonly [string, string])[] {
    const facts: (readonly [string, string])[] = [], { forces, bounds, touches, trainedDepth, energy } = answer, tool = tools[current];
    if (forces.length > 1)
      forces.forEach((force, i) => facts.push([`Force of tool ${i + 1}`, `${significant(norm(force), digitsOf(norm(force), bounds[i] ?? null))} N`]));
    if (tool?.place) {
      facts.push(['Held', nameOf(tool.place)], ['Depth', withUnit(norm(tool.at), 'm', 3)]);
      const depth = norm(tool.at), force = forces[current];
      if (force && depth > 0) facts.push(['Force along the push / depth', withUnit(dot(force, tool.at) / depth ** 2, 'N/m', 3)]);
      if (trainedDepth !== null) facts.push(['Trained to', withUnit(trainedDepth, 'm', 3)]);
      const from = tools.length > 1 ? '' : ['', ', from Taylor-Hood', ', from half-size cells'][runtime.model.info.provenance.boundReference] ?? '';
      const bound = bounds[current] ?? null;
      if (bound !== null) facts.push([`Error of the force (95 %)${from}`, `below ${withUnit(bound, 'N', 2)}`]);
    }
    const touch = touches[current];
    if (touch?.held) {
      const force = vector(touch.force), normal = vector(touch.normal), pressing = -dot(force, normal);
      facts.push(['Pressing, along the surface', `${significant(pressing, 3)}, ${significant(norm(add(force, scale(pressing, normal))), 3)} N`],
        ['Depth', withUnit(norm(vector(touch.held.displacement)), 'm', 3)]);
    }
    if (mode === 'hold' || touches.length > 0)
      facts.push(['Stored energy', energy === null ? 'not in this family' : withUnit(energy, 'J', 3)]);
    return facts;
  }

  /** The curve and what is compared in it. */
  showPlot(session: Session): void {
    const curve = curveOf(session), { mode, held, data } = session;
    this.plot.innerHTML = curve ? drawn(curve) : '';
    const more = data.rays.length > 0 ? ' Choose “Probed points and directions only” to see finite elements, too.' : '';
    setText(this.plotNote, curve ? curve.stored ? 'Line: model. Dots: finite elements. Both in the direction of the tool.' : `Line: model, in the direction of the tool.${more}`
      : mode === 'hold' && held.length < 2 ? 'Pull or push the body to see the curve.' : 'For one tool that holds the body.');
  }
}

/** Forces along the direction of the only tool; null where there is none that has moved. */
export function curveOf({ held, runtime, data, answer, limit }: Session): PlotData | null {
  const [tool] = held, [force] = answer.forces, depth = tool ? norm(tool.displacement) : 0;
  // A tool that has just come has no answer before the next picture.
  if (!tool || !force || held.length !== 1 || depth === 0) return null;
  const { place, displacement } = tool, node = nodeOf(place), most = Math.min(limit, Math.max(runtime.model.info.maxDisplacement, 1.1 * depth));
  const depths = Array.from({ length: pieces + 1 }, (_, i) => (i / pieces) * most);
  const forces = depths.map((d) => norm(vector(runtime.model.force(place, scale(d / depth, displacement)).force)));
  const ray = node === null ? null : nearestRay(data.rays, node, displacement);
  // Forces differ several times between directions: finite elements are drawn in the same one, or not.
  const isSame = ray !== null && dot(ray.direction, displacement) > (1 - 1e-9) * depth;
  return {
    curve: { depths, forces }, stored: isSame ? { depths: ray.depth_m, forces: ray.force_N.map(norm) } : null,
    now: { depth, force: norm(force) },
  };
}
