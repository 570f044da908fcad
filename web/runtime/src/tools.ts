// Several tools at the same time, at nodes or between them.
import { Touching, type Body } from './body.js';
import { bytesOf, copied, few, integer, type Engine, type Owner } from './engine.js';
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

export class Tools extends Touching {
  protected readonly what = 'tools';
  protected readonly data: number;
  private readonly tools: number;
  private readonly forces: number;
  private readonly result: number;
  private readonly out: number;
  private readonly boundsAt: number;
  private held = 0;

  constructor(
    engine: Engine,
    parent: Owner,
    private readonly model: number,
    protected readonly max: number,
    private readonly nOutput: number,
  ) {
    super(engine, parent);
    few(max);
    try {
      this.data = this.made('phn_tools', model, max);
      this.tools = this.take(max * bytesOf('phn_tool'));
      this.forces = this.take(max * 24);
      this.result = this.take(bytesOf('phn_coupled'));
      this.out = this.take(24 * nOutput);
      this.boundsAt = this.take(max * 8);
    } catch (error) {
      this.dispose();
      throw error;
    }
  }

  /** Forces of tools that hold their points; none of them: the object is free. */
  set(tools: readonly Tool[]): Coupled {
    const { engine } = this;
    this.alive();
    if (tools.length > this.max) throw new RangeError(`${tools.length} tools, but this was made for ${this.max}`);
    tools.forEach((tool, i) => putTool(engine, this.tools + i * bytesOf('phn_tool'), tool));
    this.held = 0;
    const status = engine.call('phn_couple', this.model, this.data, tools.length, this.tools, this.forces, this.result);
    this.held = tools.length;
    return {
      status,
      warnings: warningsOf(status),
      forces: engine.reals(this.forces, 3 * tools.length).slice(),
      energy: engine.real(this.result + bytesOf('phn_coupled.energy')),
      residual: engine.real(this.result + bytesOf('phn_coupled.residual')),
    };
  }

  override attach(body: Body | null, steps?: number): void {
    super.attach(body, steps);
    this.held = 0;
  }

  /** Bounds [N] of the errors of the forces of the last set(); null where there is none: outside of the trained range, too close
   * together, at a smaller level, or without `phynness calibrate`. */
  bounds(): (number | null)[] {
    const { engine } = this;
    this.alive();
    const status = engine.f['phn_coupled_bound']!(this.model, this.data, this.boundsAt);
    if (status !== undefinedHere && status < 0) throw engine.error(status, 'phn_coupled_bound');
    const bounds = Array.from(engine.reals(this.boundsAt, this.held));
    return bounds.map((bound) => (status === undefinedHere || bound >= noBound ? null : bound));
  }

  /** Displacements [m] of all output nodes, n x 3, under the tools of the last set(). */
  deform(out?: Float64Array): Float64Array {
    this.alive();
    this.engine.call('phn_coupled_deform', this.model, this.data, this.out);
    return copied(this.engine.reals(this.out, 3 * this.nOutput), out);
  }

  /** Level of later calls: an index of Model.levels. */
  set level(level: number) {
    this.alive();
    this.engine.call('phn_set_level', this.model, this.data, integer(level));
  }
}
