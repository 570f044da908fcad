// What the runtime answers for tools and spheres.
import type { Body, Contact, Level, Model, ModelTools, Sphere, Surface, Tools, Touch, Warning } from '../../runtime/src/index.js';
import { PhynnessError } from '../../runtime/src/status.js';
import { add, row, scale, zero, type V3 } from '../../shared/src/vectors.js';
import { nodeOf, placeAt, toolOf, type Place } from './places.js';
import type { HeldTool } from './state.js';

export interface Answer {
  readonly status: number;
  readonly warnings: readonly Warning[];
  /** of each tool or sphere, on the object [N] */
  readonly forces: readonly V3[];
  /** [J]; null in families without one */
  readonly energy: number | null;
  /** [m] in the direction of a tool at a node */
  readonly trainedDepth: number | null;
  /** of the error of the force [N] of the last tool, inside the trained range; null also for models without bounds */
  readonly bound: number | null;
  /** of the spheres; empty for tools */
  readonly touches: readonly Touch[];
  /** largest distance of a tool from its point [m] */
  readonly residual: number;
}

export const mostTools = 2;
/** Steps of a body for questions beside the picture. */
const manySteps = 60;

export class Runtime {
  private readonly tools: Tools;
  /** for questions beside the picture */
  private readonly asked: Tools;
  private readonly ofModel: readonly ModelTools[];
  /** answers for tools and spheres, instead of the model */
  readonly body: Body | null;
  private readonly contact_: Contact | null;
  private surface_: Surface | null = null;
  private surfaceLevels = -1;
  readonly active: ReadonlySet<number>;
  /** row of a node in output points, then in fixed points */
  readonly rows: ReadonlyMap<number, number>;
  /** displacements of the output nodes after answer() or touch(), n x 3 [m] */
  readonly field: Float64Array;

  constructor(readonly model: Model, bodyText: string | null = null) {
    const { info } = model;
    this.active = new Set(info.activeNodes);
    this.rows = new Map([...info.outputNodes, ...info.fixedNodes].map((node, i) => [node, i]));
    this.field = new Float64Array(3 * info.outputNodes.length);
    const body = this.body = bodyText === null ? null : model.body(bodyText);
    this.ofModel = body ? [] : [model.tools(mostTools), model.tools(mostTools)];
    this.tools = this.ofModel[0] ?? body!.tools(mostTools);  // what its steps leave goes on in the next picture
    this.asked = this.ofModel[1] ?? body!.tools(mostTools, manySteps);
    this.contact_ = unlessRefused(['PHN_ERROR_UNDEFINED', 'PHN_ERROR_GEOMETRY'], () => (body ?? model).contact(1));
  }
  /** Fills `field`. */
  private draw(of: Tools | Contact): void {
    if (!this.body) return void of.deform(this.field);
    const moved = of.deform();
    this.body.info.nodes.forEach((node, i) => {
      const at = 3 * (this.rows.get(node) ?? Infinity);
      if (at < this.field.length) this.field.set(moved.subarray(3 * i, 3 * i + 3), at);
    });
  }
  get hasContact(): boolean {
    return this.contact_ !== null;
  }
  get levels(): readonly Level[] {
    return this.model.levels;
  }
  /** Bounds are those of the full model. */
  private get atFullLevel(): boolean {
    return this.model.level === this.levels.length - 1;
  }
  /** @param level  index of levels; null: the full model */
  setLevel(level: number | null): void {
    const index = Math.min(level ?? this.levels.length - 1, this.levels.length - 1);
    this.model.level = index;
    for (const tools of this.ofModel) tools.level = index;
  }
  surface(levels: number): Surface {
    if (this.surfaceLevels !== levels || !this.surface_) {
      this.surface_?.dispose();
      this.surface_ = this.model.surface(levels);
      this.surfaceLevels = levels;
    }
    return this.surface_;
  }
  /** Undeformed [m]. */
  point(node: number): V3 {
    const { outputPoints, fixedPoints, outputNodes } = this.model.info, i = this.rows.get(node);
    if (i === undefined) throw new RangeError(`node ${node} is not on the surface`);
    return i < outputNodes.length ? row(outputPoints, i) : row(fixedPoints, i - outputNodes.length);
  }
  /** Present displacement of a node [m]. */
  displacement(node: number): V3 {
    const i = this.rows.get(node);
    return i !== undefined && 3 * i < this.field.length ? row(this.field, i) : [0, 0, 0];
  }
  displacementAt({ nodes, weights }: Place): V3 {
    return nodes.reduce<V3>((sum, node, i) => add(sum, scale(weights[i]!, this.displacement(node))), zero);
  }

  /** Whether a place moves with a tool. */
  canHold(place: Place): boolean {
    const rest = [toolOf(place, zero)];
    if (this.body) this.asked.set([]);
    return unlessRefused(['PHN_ERROR_NOT_ACTIVE', 'PHN_ERROR_UNDEFINED'], () => this.asked.set(rest)) !== null;
  }
  /** Forces and, in `field`, displacements under tools that hold their points. @throws PhynnessError */
  answer(tools: readonly HeldTool[]): Answer {
    const node = tools.length === 1 && !this.body ? nodeOf(tools[0]!.place) : null;
    if (node !== null) return this.atNode(node, tools[0]!.displacement);
    if (tools.length === 0 && !this.body) this.field.fill(0);
    if (tools.length === 0 && !this.body) return { ...nothing, energy: this.hasEnergy ? 0 : null };
    const all = tools.map(({ place, displacement }) => toolOf(place, displacement));
    const { status, warnings, forces, energy, residual } = this.tools.set(all);
    this.draw(this.tools);
    return {
      ...nothing, status, warnings, residual, forces: tools.map((_, i) => row(forces, i)),
      energy: this.hasEnergy ? energy : null, bound: this.body || this.atFullLevel ? this.tools.bounds().at(-1) ?? null : null,
    };
  }
  get hasEnergy(): boolean {
    return this.body !== null || this.model.info.hasEnergy;
  }
  private atNode(node: number, d: V3): Answer {
    const { status, warnings, force, energy } = this.model.force(node, d, { energy: this.model.info.hasEnergy });
    // Models without deformations still have forces.
    if (!unlessRefused(['PHN_ERROR_UNDEFINED'], () => this.model.deform(node, d, this.field))) this.field.fill(0);
    return {
      ...nothing, status, warnings, forces: [row(force, 0)], energy: energy ?? null,
      trainedDepth: this.model.trainedDepth(node, d), bound: this.atFullLevel ? this.model.bound(node, d) : null,
    };
  }

  /** Forces and field under a sphere. */
  touch(sphere: Sphere): Answer {
    if (!this.contact_) return nothing;
    const { status, warnings, energy, touches } = this.contact_.step([sphere]);
    this.draw(this.contact_);
    return {
      ...nothing, status, warnings, touches, forces: touches.map(({ force }) => row(force, 0)),
      energy: this.hasEnergy ? energy : null,
    };
  }
  endContact(): void {
    this.contact_?.reset();
  }

  /** Force of the model alone, for curves and maps. */
  forceAt(node: number, d: V3): V3 {
    return row(this.active.has(node) ? this.model.force(node, d).force : this.asked.set([toolOf(placeAt(node), d)]).forces, 0);
  }
  forceOf(tool: HeldTool, others: readonly HeldTool[]): (d: V3) => V3 {
    const node = nodeOf(tool.place);
    if (node !== null && others.length === 0 && !this.body) return (d) => this.forceAt(node, d);
    if (this.body) this.asked.set([]);
    return (d) => {
      const all = [{ ...tool, displacement: d }, ...others].map(({ place, displacement }) => toolOf(place, displacement));
      return row(this.asked.set(all).forces, 0);
    };
  }

  dispose(): void {
    this.surface_?.dispose();
    this.tools.dispose();
    this.asked.dispose();
    this.body?.dispose();
    this.contact_?.dispose();
    this.model.dispose();
  }
}

const nothing: Answer = {
  status: 0, warnings: [], forces: [], energy: null, trainedDepth: null, bound: null, touches: [], residual: 0,
};

/** What is made; null if the runtime refuses it with one of these statuses. @throws any other error */
function unlessRefused<T>(statuses: readonly string[], make: () => T): T | null {
  try {
    return make();
  } catch (error) {
    if (error instanceof PhynnessError && statuses.includes(error.statusName)) return null;
    throw error;
  }
}
