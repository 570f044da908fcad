// What touches the body, and what it answers. No page and no graphics.
import type { Place, Sphere } from '../../runtime/src/index.js';
import { PhynnessError } from '../../runtime/src/status.js';
import { boundsOf, type Bounds } from '../../shared/src/camera.js';
import { add, norm, scale, shortened, sub, type V3 } from '../../shared/src/vectors.js';
import type { Answer, HeldPlace, Part, Runtime } from './answers.js';
import { mapsOf, type MapKind } from './maps.js';
import { alongRay, type PageData } from './page_data.js';
import { meanAt, placeAt } from './places.js';

/** A tool that holds a place of the surface, or a sphere. */
export interface Tool {
  /** null: a sphere */
  readonly place: Place | null;
  /** displacement of the place, or centre of the sphere [m] */
  at: V3;
  /** a sphere that was put somewhere else, and starts there without contact */
  jumped?: boolean;
}

export class Session {
  readonly bounds: Bounds;
  readonly maps: readonly MapKind[];
  /** tools that hold places may be moved this far [m] */
  readonly limit: number;
  mode: 'hold' | 'sphere' = 'hold';
  tools: Tool[] = [];
  /** the tool that was moved last */
  private last: Tool | null = null;
  /** how many tools at most */
  most: 1 | 2 = 1;
  /** tools hold probed points in stored directions only */
  probedOnly = false;
  /** name of a map; 'parts': the parts of the surface */
  map = 'parts';
  readonly sphere: { radius: number; friction: number; grasp: boolean };
  answer: Answer;
  /** why the last answer was refused */
  problem: string | null = null;
  /** forces of a body still change: the next picture goes on with its steps */
  restless = false;
  private patience = 0;

  constructor(readonly runtime: Runtime, readonly data: PageData) {
    const { outputPoints, fixedPoints, maxDisplacement } = runtime.model.info;
    this.bounds = boundsOf([...outputPoints, ...fixedPoints]);
    this.limit = 2 * maxDisplacement;
    this.sphere = { radius: Number((0.08 * this.bounds.radius).toPrecision(1)), friction: 0.3, grasp: false };
    this.maps = mapsOf(runtime, data.validation);
    this.answer = runtime.hold([]);
  }

  /** Computes the answer to the present tools. @param moved  false: goes on with the steps of a body */
  update(moved = true): void {
    const before = this.answer.forces;
    try {
      this.answer = this.mode === 'hold' ? this.runtime.hold(this.held) : this.touch();
      this.problem = null;
    } catch (error) {
      if (!(error instanceof PhynnessError)) throw error;
      this.problem = `These tools are refused: ${error.reason}.`;
    }
    const { forces } = this.answer, largest = Math.max(0, ...forces.map(norm));
    this.patience = moved ? 100 : this.patience - 1;
    this.restless = this.runtime.body !== null && this.patience > 0
      && (forces.length !== before.length || forces.some((force, i) => norm(sub(force, before[i]!)) > 1e-9 * largest));
  }
  /** The tools that hold places. */
  get held(): HeldPlace[] {
    return this.tools.flatMap(({ place, at }) => (place ? [{ place, displacement: at }] : []));
  }
  private touch(): Answer {
    const { radius, friction, grasp } = this.sphere;
    const spheres = (off: boolean) => this.tools.map(({ at, jumped }): Sphere =>
      ({ center: at, radius, friction, mode: off && jumped ? 'off' : grasp ? 'grasp' : 'press' }));
    if (this.tools.some(({ jumped }) => jumped)) this.runtime.touch(spheres(true));
    for (const tool of this.tools) tool.jumped = false;
    return this.runtime.touch(spheres(false));
  }
  /** Index of the tool that was moved last; of none -1. */
  get current(): number {
    const index = this.last ? this.tools.indexOf(this.last) : -1;
    return index < 0 ? this.tools.length - 1 : index;
  }
  /** Whether anything touches the body. */
  get touching(): boolean {
    return this.mode === 'hold' ? this.tools.length > 0 : this.answer.touches.some(({ inContact }) => inContact);
  }

  // ---- tools that hold --------------------------------------------------------------------------------------------

  /** The place that a tool holds which touches the undeformed surface at x [m], and how the model answers there. */
  placeNear(x: V3): { place: Place; part: Part } {
    const { runtime } = this, { active, parts, rows } = runtime, distance = (node: number) => norm(sub(runtime.point(node), x));
    const nearest = (nodes: Iterable<number>) => [...nodes].reduce((best, node) => (distance(node) < distance(best) ? node : best));
    if (this.probedOnly) return { place: placeAt(nearest(active)), part: 'nonlinear' };
    const { tool: { nodes, weights }, distance: gap } = runtime.model.nearest(x), place = { nodes, weights };
    // The nearest place that can be touched may be far away.
    const node = nearest(rows.keys()), beside = parts[rows.get(node)!]!, isFar = (beside === 'fixed' || beside === 'untouchable') && Math.abs(gap) > distance(node);
    return { place, part: isFar ? beside : runtime.partAt(place) };
  }
  /** Holds a place. @param spared  tools that must stay */
  hold(place: Place, spared: readonly Tool[] = []): Tool {
    const same = this.tools.find((tool) => JSON.stringify(tool.place) === JSON.stringify(place));
    if (same) return same;
    const first = this.tools.find((tool) => !spared.includes(tool));
    if (this.tools.length >= this.most) this.tools = this.tools.filter((tool) => tool !== first);
    const tool = { place, at: [0, 0, 0] as V3 };
    this.tools.push(tool);
    return tool;
  }
  /** Moves a tool to a displacement, or a sphere to a position [m]. */
  move(tool: Tool, to: V3): void {
    this.last = tool;
    const { place } = tool, node = this.probedOnly && place ? place.nodes[0]! : null;
    tool.at = place ? shortened(node === null ? to : alongRay(this.data.rays, node, to), this.limit) : to;
  }
  restPoint(place: Place): V3 {
    return meanAt(place, (node) => this.runtime.point(node));
  }

  // ---- modes and spheres ------------------------------------------------------------------------------------------

  /** Lets go of the body; spheres go back above it, side by side. */
  letGo(): void {
    this.tools = [];
    this.runtime.endContact();
    if (this.mode === 'hold') return;
    const { outputPoints } = this.runtime.model.info, { center } = this.bounds, { radius } = this.sphere;
    const top = outputPoints.reduce((most, x, i) => (i % 3 === 2 ? Math.max(most, x) : most), -Infinity);
    for (let i = 0; i < this.most; ++i)
      this.tools.push({ place: null, at: [center[0] + 1.5 * radius * (2 * i + 1 - this.most), center[1], top + 1.2 * radius] });
  }
  setMode(mode: Session['mode']): void {
    this.mode = mode;
    this.letGo();
  }
  setMost(most: 1 | 2): void {
    this.most = most;
    if (this.mode === 'hold') this.tools = this.tools.slice(-most);
    else this.letGo();
  }
  /** Puts a sphere beside a point of the undeformed surface, just not in contact. */
  putSphere(sphere: Tool, surface: V3, normal: V3): void {
    sphere.at = add(surface, scale(1.15 * this.sphere.radius, normal));
    sphere.jumped = true;
  }
}
