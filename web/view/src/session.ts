// A model, what touches it, and what it answers. No page and no graphics.
import { PhynnessError } from '../../runtime/src/status.js';
import { add, norm, row, scale, shortened, sub, unit, zero, type V3 } from '../../shared/src/vectors.js';
import { boundsOf, type Bounds } from '../../shared/src/camera.js';
import type { Answer, Runtime } from './answers.js';
import { mapsOf, outwardNormals, usualPalpationDepth, type MapKind } from './maps.js';
import type { PageData } from './page_data.js';
import { nodeOf, placeAt, samePlace, type Place } from './places.js';
import type { HeldTool, State } from './state.js';

/** The sphere as a tool; other numbers are tools that hold the body. */
export const sphereTool = 0;

export class Session {
  readonly bounds: Bounds;
  readonly normals: Float32Array;
  readonly maps: readonly MapKind[];
  /** tools may be moved this far [m] */
  readonly limit: number;
  answer: Answer;
  /** why the last answer was refused */
  problem: string | null = null;
  /** the node of the keyboard */
  cursor: number;
  /** forces of a body still change: the next picture goes on with its steps */
  restless = false;
  /** pictures since something moved */
  private waited = 0;
  private moved = '';
  private readonly numbers: number[] = [];
  private next = 1;

  constructor(readonly runtime: Runtime, readonly data: PageData, readonly state: State) {
    const { outputPoints, fixedPoints, activeNodes, maxDisplacement } = runtime.model.info;
    this.bounds = boundsOf([...outputPoints, ...fixedPoints]);
    this.normals = outwardNormals(runtime);
    this.limit = 2 * maxDisplacement;
    this.cursor = activeNodes[0] ?? 0;
    if (state.palpationDepth === 0) state.palpationDepth = usualPalpationDepth(runtime);
    if (state.sphere.radius === 0) state.sphere.radius = Number((0.08 * this.bounds.radius).toPrecision(1));
    state.tools = state.tools.filter(({ place }) => this.canHold(place));
    state.tools.forEach((tool) => {
      tool.displacement = shortened(tool.displacement, this.limit);
      this.numbers.push(this.next++);
    });
    if (state.level !== null && state.level >= runtime.levels.length) state.level = null;
    runtime.setLevel(state.level);
    this.maps = mapsOf(runtime, data.validation, () => state.palpationDepth);
    if (!this.maps.some(({ name }) => name === state.map)) state.map = 'none';
    if (state.mode === 'sphere') this.approach();
    this.answer = runtime.answer([]);
    this.update();
  }

  /** Computes the answer to the present tools. */
  update(): void {
    const { state, runtime } = this, before = this.answer.forces, moved = JSON.stringify([state.mode, state.tools, state.sphere]);
    try {
      if (state.mode === 'hold') this.answer = runtime.answer(state.tools);
      else if (state.sphere.center) {
        const { center, radius, friction, grasp } = state.sphere;
        this.answer = runtime.touch({ center, radius, friction, mode: grasp ? 'grasp' : 'press' });
      } else this.answer = runtime.answer([]);
      this.problem = null;
    } catch (error) {
      if (!(error instanceof PhynnessError)) throw error;
      this.problem = `These tools are refused: ${error.reason}.`;
    }
    this.waited = moved === this.moved ? this.waited + 1 : 0;
    this.moved = moved;
    const { forces } = this.answer, largest = Math.max(0, ...forces.map(norm));
    this.restless = runtime.body !== null && this.waited < 100
      && (forces.length !== before.length || forces.some((force, i) => norm(sub(force, before[i]!)) > 1e-9 * largest));
  }

  // ---- places -----------------------------------------------------------------------------------------------------

  canHold(place: Place): boolean {
    const { runtime } = this, node = nodeOf(place);
    if (node !== null && !runtime.body) return runtime.active.has(node);
    return place.nodes.every((n) => runtime.rows.has(n)) && runtime.canHold(place);
  }
  /** The place that a tool holds which touches the undeformed surface at x [m]; null: nothing near was trained. */
  placeNear(x: V3): Place | null {
    const { runtime, state } = this;
    if (!state.atNodes) {
      const { nodes, weights } = runtime.model.nearest(x).tool, place = { nodes, weights };
      if (this.canHold(place)) return place;
    }
    let best: number | null = null, nearest = 0.3 * this.bounds.radius;
    for (const node of runtime.active) {
      const distance = norm(sub(runtime.point(node), x));
      if (distance < nearest) {
        nearest = distance;
        best = node;
      }
    }
    return best === null ? null : placeAt(best);
  }
  /** Undeformed [m]. */
  restPoint({ nodes, weights }: Place): V3 {
    return nodes.reduce<V3>((sum, node, i) => add(sum, scale(weights[i]!, this.runtime.point(node))), zero);
  }
  /** Outward unit normal at rest. */
  normalAt({ nodes, weights }: Place): V3 {
    return unit(nodes.reduce<V3>((sum, node, i) => add(sum, scale(weights[i]!, row(this.normals, this.runtime.rows.get(node)!))), zero));
  }
  /** The tools to which maps belong; null: a sphere touches the body, whose fields are not known. */
  get mapTools(): readonly HeldTool[] | null {
    if (this.state.mode === 'hold') return this.state.tools;
    return this.answer.touches.some(({ inContact }) => inContact) ? null : [];
  }
  pointOf(tool: HeldTool): V3 {
    return add(this.restPoint(tool.place), tool.displacement);
  }

  // ---- tools that hold --------------------------------------------------------------------------------------------

  /** Holds a place; a tool that is there already is taken. @param spared  numbers of tools that must stay */
  hold(place: Place, spared: readonly number[] = []): number {
    const { tools } = this.state, at = tools.findIndex((tool) => samePlace(tool.place, place));
    if (at >= 0) return this.numbers[at]!;
    while (tools.length >= this.state.most) {
      const index = this.numbers.findIndex((n) => !spared.includes(n));
      if (index < 0) break;
      this.remove(index);
    }
    tools.push({ place, displacement: zero });
    this.numbers.push(this.next);
    const node = nodeOf(place);
    if (node !== null) this.cursor = node;
    return this.next++;
  }
  toolOf(number: number): HeldTool | null {
    return this.state.tools[this.numbers.indexOf(number)] ?? null;
  }
  get lastNumber(): number | null {
    return this.state.mode === 'sphere' ? sphereTool : (this.numbers.at(-1) ?? null);
  }
  numberOf(index: number): number {
    return this.numbers[index]!;
  }
  /** Moves a tool to a displacement, or the sphere to a position [m]. */
  move(number: number, to: V3): void {
    if (number === sphereTool) this.state.sphere.center = to;
    const tool = this.toolOf(number);
    if (tool) tool.displacement = shortened(to, this.limit);
  }
  /** What move() would leave where it is. */
  positionOf(number: number): V3 {
    return number === sphereTool ? (this.state.sphere.center ?? zero) : (this.toolOf(number)?.displacement ?? zero);
  }
  letGo(number: number): void {
    const index = this.numbers.indexOf(number);
    if (index >= 0) this.remove(index);
  }
  letGoAll(): void {
    while (this.numbers.length > 0) this.remove(0);
    this.state.sphere.center = null;
    this.runtime.endContact();
    if (this.state.mode === 'sphere') this.approach();
  }
  /** Replaces all tools. */
  setTools(tools: readonly HeldTool[]): void {
    const held = this.state.tools;
    // Tools that stay where they hold the body stay the same.
    if (tools.length === held.length && tools.every(({ place }, i) => samePlace(place, held[i]!.place))) {
      tools.forEach(({ displacement }, i) => this.move(this.numbers[i]!, displacement));
      return;
    }
    while (this.numbers.length > 0) this.remove(0);
    this.state.most = Math.max(this.state.most, tools.length);
    for (const { place, displacement } of tools) this.move(this.hold(place), displacement);
  }
  private remove(index: number): void {
    this.state.tools.splice(index, 1);
    this.numbers.splice(index, 1);
  }

  // ---- the sphere -------------------------------------------------------------------------------------------------

  setMode(mode: State['mode']): void {
    if (mode === 'sphere' && !this.runtime.hasContact) return;
    this.letGoAll();
    this.state.mode = mode;
    if (mode === 'sphere') this.approach();
  }
  /** Puts the sphere beside a point of the undeformed surface, just not in contact. */
  putSphere(surface: V3, normal: V3): void {
    this.runtime.endContact();
    this.state.sphere.center = add(surface, scale(1.15 * this.state.sphere.radius, normal));
    this.update();
  }
  /** A sphere without a position is put above the body; one with a position comes to it from far above. */
  private approach(): void {
    const { sphere } = this.state, { center, radius } = this.bounds;
    this.runtime.endContact();
    if (!sphere.center) {
      const { outputPoints, fixedPoints } = this.runtime.model.info;
      const top = [...outputPoints, ...fixedPoints].reduce((most, x, i) => (i % 3 === 2 ? Math.max(most, x) : most), -Infinity);
      sphere.center = [center[0], center[1], top + 1.2 * sphere.radius];
      return;
    }
    const to = sphere.center, normal = unit(sub(to, center));
    this.runtime.touch({ center: add(to, scale(2 * radius, normal)), radius: sphere.radius, friction: sphere.friction });
  }

  setLevel(level: number | null): void {
    this.state.level = level;
    this.runtime.setLevel(level);
  }
}
