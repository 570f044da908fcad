// The figures of the panel.
import { shown, significant } from '../../shared/src/numbers.js';
import { dot, norm, vector, type V3 } from '../../shared/src/vectors.js';
import type { Answer } from './answers.js';
import { byId, setFacts, setText } from './dom.js';
import { nearestRay } from './page_data.js';
import { nameOf, nodeOf } from './places.js';
import { DepthPlot, type PlotData } from './plot.js';
import type { Session } from './session.js';

const withUnit = (x: number, unitName: string, digits: number): string => {
  const { unit, factor } = shown(unitName, x);
  return `${significant(x * factor, digits)} ${unit}`;
};
/** Pieces of the curve, of a model and of a body. */
const pieces = 40, piecesOfBody = 12;

/** Smallest noticeable difference of forces. */
const noticeable = 0.1;

/** The class of a colour, a word and a sentence with the reason.
 * @param bound  of the error, over the force; null: not known. @param ofBody  not of the model */
function verdictOf({ warnings }: Answer, bound: number | null, ofBody: boolean): readonly [string, string, string] {
  if (warnings.includes('unsettled'))
    return ['beyond', 'unsettled', `The tools ${ofBody ? 'moved faster than the body settles, or ' : ''}are too close together to hold all points.`];
  if (warnings.includes('near'))
    return ['beyond', 'too near', 'The tools are nearer than half a radius and act through springs between them.'];
  if (warnings.includes('outside')) return ['beyond', 'beyond data', 'Deeper or stronger than the training data, or beside fixed nodes.'];
  if (bound !== null && bound > noticeable) return ['fair', 'inexact', 'The error of the force may exceed a tenth of it.'];
  if (warnings.includes('incomplete')) return ['fair', 'incomplete', 'Some directions of this node were not trained to the full depth.'];
  return ['good', 'inside range', 'No warning.'];
}

export class Readouts {
  private readonly newtons = byId('newtons', HTMLElement);
  private readonly verdict = byId('verdict', HTMLElement);
  private readonly reason = byId('verdict-reason', HTMLElement);
  private readonly note = byId('body-note', HTMLElement);
  private readonly table = byId('forces', HTMLTableElement);
  private readonly quantities = byId('quantities', HTMLElement);
  private readonly plotElement = byId('plot', HTMLElement);
  private readonly plotNote = byId('plot-note', HTMLElement);
  private readonly plot = new DepthPlot(this.plotElement);

  show(session: Session): void {
    const { answer, state } = session, { tools } = state, forces = answer.forces;
    const touching = state.mode === 'hold' ? tools.length > 0 : (answer.touches[0]?.inContact ?? false);
    const last = forces.at(-1);
    setText(this.newtons, last ? significant(norm(last), 6) : '0');
    const { body } = session.runtime;
    const [kind, word, reason] = verdictOf(answer, last && answer.bound !== null ? answer.bound / norm(last) : null, body !== null);
    this.verdict.dataset['kind'] = touching ? kind : 'unknown';
    setText(this.verdict, touching ? word : state.mode === 'sphere' ? 'no contact' : 'at rest');
    setText(this.reason, touching ? reason : 'Nothing touches the body.');
    this.note.hidden = body === null;
    if (body) setText(this.note, `Forces and deformation come from the reduced body (${body.info.nModes} modes, ${body.info.nCells} cells).`);
    this.showTable(session, forces);
    setFacts(this.quantities, this.facts(session));
  }

  private showTable({ state }: Session, forces: readonly V3[]): void {
    const many = forces.length > 1;
    this.table.hidden = !(state.components || many) || forces.length === 0;
    if (this.table.hidden) return;
    const names = state.mode === 'sphere' ? ['sphere'] : state.tools.map(({ place }) => nodeOf(place) !== null ? nameOf(place) : 'between nodes');
    const rows = forces.map((force, i) => [names[i] ?? '', ...force.map((x) => significant(x, 4)), significant(norm(force), 6)]);
    this.table.tBodies[0]!.replaceChildren(...rows.map((cells) => {
      const row = document.createElement('tr');
      row.append(...cells.map((text) => Object.assign(document.createElement('td'), { textContent: text })));
      return row;
    }));
  }

  private facts(session: Session): (readonly [string, string])[] {
    const { answer, state, runtime } = session, tool = state.tools.at(-1), facts: [string, string][] = [];
    if (state.mode === 'hold' && tool) {
      facts.push(['Held', nameOf(tool.place)]);
      const depth = norm(tool.displacement), middle = norm(runtime.displacementAt(tool.place));
      facts.push(['Depth', withUnit(depth, 'm', 4)]);
      // A round tool moves the mean of the surface under it.
      if (middle > 1.001 * depth) facts.push(['Its middle moves', withUnit(middle, 'm', 4)]);
      if (answer.trainedDepth !== null) facts.push(['Trained to', withUnit(answer.trainedDepth, 'm', 3)]);
      const reference = runtime.body ? 0 : runtime.model.info.provenance.boundReference;
      const finer = ['', ', from Taylor-Hood', ', from half-size cells'][reference] ?? '';
      if (answer.bound !== null) facts.push([`Error of the force (95 %)${finer}`, `below ${withUnit(answer.bound, 'N', 2)}`]);
    }
    const [touch] = answer.touches;
    if (state.mode === 'sphere' && touch?.inContact) {
      const force = vector(touch.force), pressing = -dot(force, vector(touch.normal));
      facts.push(['Pressing, along the surface', `${significant(pressing, 3)}, ${significant(Math.sqrt(Math.max(0, dot(force, force) - pressing ** 2)), 3)} N`]);
      if (touch.held) facts.push(['Surface pressed by', withUnit(norm(vector(touch.held.displacement)), 'm', 3)]);
      if (touch.scale < 1) facts.push(['Force scaled by', significant(touch.scale, 3)]);
    }
    facts.push(['Stored energy', answer.energy === null ? 'not in this family' : withUnit(answer.energy, 'J', 4)]);
    if (answer.residual > 1e-9) facts.push(['Points follow within', withUnit(answer.residual, 'm', 2)]);
    if (state.tools.length > 1) facts.push(['Distance of the tools', withUnit(distance(session), 'm', 4)]);
    return facts;
  }

  /** Force along the present direction of the last tool. Costs up to a few milliseconds between nodes. */
  showPlot(session: Session): void {
    const { state, runtime, data, answer, limit } = session, tool = state.mode === 'hold' ? state.tools.at(-1) : undefined;
    const force = answer.forces.at(-1);
    if (!tool || !force || norm(tool.displacement) === 0) {
      this.plot.show(null);
      setText(this.plotNote, state.mode === 'sphere' ? 'For tools that hold the body.' : 'Pull or push the body to see the curve.');
      this.plotElement.setAttribute('aria-label', 'No tool has moved');
      return;
    }
    const depth = norm(tool.displacement), node = nodeOf(tool.place);
    const most = Math.min(limit, Math.max(runtime.model.info.maxDisplacement, 1.1 * depth));
    const others = state.tools.slice(0, -1), at = runtime.forceOf(tool, others);
    const n = runtime.body ? piecesOfBody : pieces, depths = Array.from({ length: n + 1 }, (_, i) => (i / n) * most);
    const forces = forcesAlong(at, tool.displacement, depths);
    const near = node !== null && others.length === 0 ? nearestRay(data.rays, node, tool.displacement) : null;
    const stored = near
      ? { depths: near.ray.depth_m, forces: near.ray.force_N.map(norm), model: forcesAlong(at, near.ray.direction, depths) }
      : null;
    this.plot.show({ curve: { depths, forces }, stored, now: { depth, force: norm(force) } } satisfies PlotData);
    const angle = near ? Math.round((near.angle * 180) / Math.PI) : 0;
    setText(this.plotNote, `Line: ${runtime.body ? 'body' : 'model'} along this direction.${near ? ` Dots: finite elements; dashed: ${runtime.body ? 'body' : 'model'}; both in the nearest trained direction, ${angle}° away.` : ''}`);
    this.plotElement.setAttribute('aria-label', `Force against depth along the present direction; now ${withUnit(norm(force), 'N', 4)} at ${withUnit(depth, 'm', 4)}`);
  }
}

/** Sizes of the force [N] at depths [m] along a direction of any length. */
export function forcesAlong(at: (displacement: V3) => V3, direction: V3, depths: readonly number[]): number[] {
  const size = norm(direction);
  return depths.map((depth) => norm(at(direction.map((c) => (c * depth) / size) as unknown as V3)));
}

const distance = (session: Session): number => {
  const [a, b] = session.state.tools.map((tool) => session.pointOf(tool));
  return a && b ? norm([a[0] - b[0], a[1] - b[1], a[2] - b[2]]) : 0;
};
