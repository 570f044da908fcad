// What the runtime answers for tools and spheres: a model for one tool; a reduced body, if there is one, for two and for spheres.
import type { Body, Contact, Model, Place, Sphere, Tools, Touch, Warning } from '../../runtime/src/index.js';
import { PhynnessError } from '../../runtime/src/status.js';
import { row, zero, type V3 } from '../../shared/src/vectors.js';
import { meanAt, placeAt } from './places.js';

export interface Answer {
  readonly warnings: readonly Warning[];
  /** of each tool or sphere, on the object [N] */
  readonly forces: readonly V3[];
  /** of the errors of these forces [N]; null: not known */
  readonly bounds: readonly (number | null)[];
  /** [J]; null in families without one */
  readonly energy: number | null;
  /** of the training [m], in the direction of the only tool; null: several tools, or between nodes of node probes */
  readonly trainedDepth: number | null;
  /** of the spheres; empty for tools */
  readonly touches: readonly Touch[];
}
/** A place that is held at a displacement [m]. */
export interface HeldPlace {
  readonly place: Place;
  readonly displacement: V3;
}
/** How the model answers at a node. */
export type Part = 'nonlinear' | 'linear' | 'untouchable' | 'fixed';

const nothing: Answer = { warnings: [], forces: [], bounds: [], energy: 0, trainedDepth: null, touches: [] };

export class Runtime {
  readonly active: ReadonlySet<number>;
  /** row of a node in output points, then in fixed points */
  readonly rows: ReadonlyMap<number, number>;
  readonly parts: readonly Part[];
  /** displacements of the output nodes after hold() or touch(), n x 3 [m] */
  readonly field: Float64Array;
  readonly body: Body | null;
  private readonly several: Tools | null;
  private readonly contact: Contact | null;

  constructor(readonly model: Model, bodyText: string | null = null) {
    const { activeNodes, outputNodes, fixedNodes } = model.info;
    this.active = new Set(activeNodes);
    this.rows = new Map([...outputNodes, ...fixedNodes].map((node, i) => [node, i]));
    this.field = new Float64Array(3 * outputNodes.length);
    this.body = bodyText === null ? null : model.body(bodyText);
    this.several = (this.body ?? model).tools(2);
    if (!this.body && activeNodes.length > 1) {
      const two = [...activeNodes.subarray(0, 2)].map((node) => held({ place: placeAt(node), displacement: zero }));
      if (!unlessRefused(() => this.several!.set(two))) this.several = null;
    }
    this.contact = unlessRefused(() => (this.body ?? model).contact(this.several ? 2 : 1));
    this.parts = [...outputNodes].map((node) => this.partAt(placeAt(node))).concat([...fixedNodes].map(() => 'fixed'));
  }
  get mostTools(): 1 | 2 {
    return this.several ? 2 : 1;
  }
  get hasContact(): boolean {
    return this.contact !== null;
  }
  /** Undeformed [m]. */
  point(node: number): V3 {
    const { outputPoints, fixedPoints, outputNodes } = this.model.info, i = this.rows.get(node);
    if (i === undefined) throw new RangeError(`node ${node} is not on the surface`);
    return i < outputNodes.length ? row(outputPoints, i) : row(fixedPoints, i - outputNodes.length);
  }
  /** Present displacement of the surface at a place [m]. */
  displacementAt(place: Place): V3 {
    return meanAt(place, (node) => {
      const i = this.rows.get(node);
      return i !== undefined && 3 * i < this.field.length ? row(this.field, i) : zero;
    });
  }
  partAt(place: Place): Part {
    const rest = unlessRefused(() => this.model.force(place, zero));
    return rest === null ? 'untouchable' : rest.warnings.includes('outside') ? 'linear' : 'nonlinear';
  }

  /** Forces and, in `field`, displacements under tools that hold places. @throws PhynnessError */
  hold(tools: readonly HeldPlace[]): Answer {
    if (tools.length === 0) {
      this.field.fill(0);
      this.several?.set([]);
      return nothing;
    }
    if (tools.length === 1) return this.holdOne(tools[0]!);
    if (!this.several) throw new RangeError('without a reduced body one round tool is answered');
    const { warnings, forces, energy } = this.several.set(tools.map(held));
    this.draw(this.several);
    return { ...nothing, warnings, forces: tools.map((_, i) => row(forces, i)), bounds: this.several.bounds(), energy: this.energy(energy) };
  }
  private holdOne({ place, displacement }: HeldPlace): Answer {
    const { model, field } = this, { warnings, force, energy } = model.force(place, displacement, { energy: model.info.hasEnergy });
    // Models without deformations still have forces.
    if (!unlessRefused(() => model.deform(place, displacement, field))) field.fill(0);
    return {
      ...nothing, warnings, forces: [row(force, 0)], bounds: [model.bound(place, displacement)], energy: this.energy(energy ?? 0),
      trainedDepth: unlessRefused(() => model.trainedDepth(place, displacement)),
    };
  }
  /** The same under spheres; sphere i is the same one in every call. */
  touch(spheres: readonly Sphere[]): Answer {
    if (!this.contact) return nothing;
    const { warnings, energy, touches } = this.contact.step(spheres);
    this.draw(this.contact);
    const forces = touches.map(({ force }) => row(force, 0));
    return { ...nothing, warnings, touches, forces, bounds: forces.map(() => null), energy: this.energy(energy) };
  }
  endContact(): void {
    this.contact?.reset();
  }
  /** Values of a field of the model at the output nodes under one tool; null: not known. */
  fieldOf({ place, displacement }: HeldPlace, field: number): Float64Array | null {
    return unlessRefused(() => this.model.field(place, displacement, field));
  }

  private energy(joules: number): number | null {
    return this.body || this.model.info.hasEnergy ? joules : null;
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
}

const held = ({ place: { nodes, weights }, displacement }: HeldPlace) => ({ nodes, weights, displacement });

/** What the runtime answers; null where the model has no such answer. @throws any other error */
function unlessRefused<T>(make: () => T): T | null {
  try {
    return make();
  } catch (error) {
    const undefinedHere = ['PHN_ERROR_NOT_ACTIVE', 'PHN_ERROR_UNDEFINED', 'PHN_ERROR_ROUND_TOOLS', 'PHN_ERROR_GEOMETRY'];
    if (error instanceof PhynnessError && undefinedHere.includes(error.statusName)) return null;
    throw error;
  }
}
