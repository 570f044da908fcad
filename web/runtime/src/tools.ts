// Several tools at the same time, at nodes or between them: of a model, or of a reduced body.
import { bytesOf, copied, few, integer, Owner, type Engine } from './engine.js';
import { noBound, undefinedHere, warningsOf, type Warning } from './status.js';
import { putTool, type Tool } from './tool.js';

export interface Coupled {
  readonly status: number;
  readonly warnings: readonly Warning[];
  /** n x 3 [N], on the object */
  readonly forces: Float64Array;
  /** [J]; 0 in family rbfn */
  readonly energy: number;
  /** largest distance of a tool from the point that it holds [m] */
  readonly residual: number;
}

export abstract class Tools extends Owner {
  protected readonly what = 'tools';
  protected readonly tools: number;
  protected readonly forces: number;
  protected readonly result: number;
  protected readonly out: number;
  protected readonly boundsAt: number;
  private held = 0;

  /** @param nField  nodes of a field */
  constructor(engine: Engine, parent: Owner, private readonly max: number, private readonly nField: number, resultBytes: number) {
    super(engine, parent);
    few(max);
    try {
      this.tools = this.take(max * bytesOf('phn_tool'));
      this.forces = this.take(max * 24);
      this.result = this.take(resultBytes);
      this.out = this.take(24 * nField);
      this.boundsAt = this.take(max * 8);
    } catch (error) {
      this.dispose();
      throw error;
    }
  }
  /** Calls of the runtime: forces of the first n tools, their bounds, the field. @returns the status */
  protected abstract hold(n: number): number;
  protected abstract bound(): number;
  protected abstract field(): void;
  /** Energy and residual after hold(). */
  protected abstract held_(): { energy: number; residual: number };

  /** Forces of tools that hold their points; none of them: the object is free. */
  set(tools: readonly Tool[]): Coupled {
    const { engine } = this;
    this.alive();
    if (tools.length > this.max) throw new RangeError(`${tools.length} tools, but this was made for ${this.max}`);
    tools.forEach((tool, i) => putTool(engine, this.tools + i * bytesOf('phn_tool'), tool));
    this.held = 0;
    const status = this.hold(tools.length);
    this.held = tools.length;
    return { status, warnings: warningsOf(status), forces: engine.reals(this.forces, 3 * tools.length).slice(), ...this.held_() };
  }

  /** Bounds [N] of the errors of the forces of the last set(); null where there is none: outside of the trained range, too close
   * together, at a smaller level, or without `phynness calibrate`. */
  bounds(): (number | null)[] {
    const { engine } = this;
    this.alive();
    const status = this.bound();
    if (status !== undefinedHere && status < 0) throw engine.error(status, 'bounds');
    const bounds = Array.from(engine.reals(this.boundsAt, this.held));
    return bounds.map((bound) => (status === undefinedHere || bound >= noBound ? null : bound));
  }

  /** Displacements [m], n x 3, under the tools of the last set(): of all output nodes of a model, of all nodes of a body. */
  deform(out?: Float64Array): Float64Array {
    this.alive();
    this.field();
    return copied(this.engine.reals(this.out, 3 * this.nField), out);
  }
}

export class ModelTools extends Tools {
  private readonly data: number;

  constructor(engine: Engine, parent: Owner, private readonly model: number, max: number, nOutput: number) {
    super(engine, parent, max, nOutput, bytesOf('phn_coupled'));
    try {
      this.data = this.made('phn_tools', model, max);
    } catch (error) {
      this.dispose();
      throw error;
    }
  }
  protected hold(n: number): number {
    return this.engine.call('phn_couple', this.model, this.data, n, this.tools, this.forces, this.result);
  }
  protected bound(): number {
    return this.engine.f['phn_coupled_bound']!(this.model, this.data, this.boundsAt);
  }
  protected field(): void {
    this.engine.call('phn_coupled_deform', this.model, this.data, this.out);
  }
  protected held_(): { energy: number; residual: number } {
    const real = (member: Parameters<typeof bytesOf>[0]) => this.engine.real(this.result + bytesOf(member));
    return { energy: real('phn_coupled.energy'), residual: real('phn_coupled.residual') };
  }

  /** Level of later calls: an index of Model.levels. */
  set level(level: number) {
    this.alive();
    this.engine.call('phn_set_level', this.model, this.data, integer(level));
  }
}

/** Tools of a body, each set() of which goes on from the last deformation with some steps. */
export class BodyTools extends Tools {
  private readonly state: number;

  constructor(engine: Engine, parent: Owner, private readonly body: number, max: number, nNodes: number, private readonly steps: number) {
    super(engine, parent, max, nNodes, bytesOf('phn_body_pressed'));
    try {
      this.state = this.made('phn_body_state', body, max);
    } catch (error) {
      this.dispose();
      throw error;
    }
  }
  protected hold(n: number): number {
    return this.engine.call('phn_body_press', this.body, this.state, n, this.tools, this.steps, this.forces, this.result);
  }
  protected bound(): number {
    return this.engine.f['phn_body_bound']!(this.body, this.state, this.boundsAt);
  }
  protected field(): void {
    this.engine.call('phn_body_deform', this.body, this.state, this.out);
  }
  protected held_(): { energy: number; residual: number } {
    const real = (member: Parameters<typeof bytesOf>[0]) => this.engine.real(this.result + bytesOf(member));
    return { energy: real('phn_body_pressed.energy'), residual: real('phn_body_pressed.behind_m') };
  }
}
