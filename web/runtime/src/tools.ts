// Several tools at the same time, at nodes or between them: of a model, or of a reduced body.
import { bytesOf, copied, few, Owner, type Engine } from './engine.js';
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

/** The C functions of tools, and what their result holds. */
const functions = {
  model: { data: 'phn_data', hold: 'phn_couple', bound: 'phn_bound', field: 'phn_coupled_deform', result: 'phn_coupled',
    energy: 'phn_coupled.energy', residual: 'phn_coupled.residual' },
  body: { data: 'phn_body_state', hold: 'phn_body_force', bound: 'phn_body_bound', field: 'phn_body_deform', result: 'phn_body_report',
    energy: 'phn_body_report.energy', residual: 'phn_body_report.residual_m' },
} as const;

export class Tools extends Owner {
  protected readonly what = 'tools';
  private readonly data: number;
  private readonly f: (typeof functions)['model' | 'body'];
  private readonly steps: readonly number[];
  private readonly tools: number;
  private readonly forces: number;
  private readonly result: number;
  private readonly out: number;
  private readonly boundsAt: number;
  private held = 0;

  /** @param of  the model or the body. @param nField  nodes of a field. @param steps  of a body for each set(), which goes on from
   * the last deformation; null: of a model */
  constructor(engine: Engine, parent: Owner, private readonly of: number, private readonly max: number, private readonly nField: number,
    steps: number | null) {
    super(engine, parent);
    few(max);
    this.f = functions[steps === null ? 'model' : 'body'];
    this.steps = steps === null ? [] : [steps];
    this.data = this.made(this.f.data, of, max);
    this.tools = this.take(max * bytesOf('phn_tool'));
    this.forces = this.take(max * 24);
    this.result = this.take(bytesOf(this.f.result));
    this.out = this.take(24 * nField);
    this.boundsAt = this.take(max * 8);
  }

  /** Forces of tools that hold their points; none of them: the object is free. */
  set(tools: readonly Tool[]): Coupled {
    const { engine } = this;
    this.alive();
    if (tools.length > this.max) throw new RangeError(`${tools.length} tools, but this was made for ${this.max}`);
    tools.forEach((tool, i) => putTool(engine, this.tools + i * bytesOf('phn_tool'), tool));
    this.held = 0;
    const status = engine.call(this.f.hold, this.of, this.data, tools.length, this.tools, ...this.steps, this.forces, this.result);
    this.held = tools.length;
    return {
      status, warnings: warningsOf(status), forces: engine.reals(this.forces, 3 * tools.length).slice(),
      energy: engine.real(this.result + bytesOf(this.f.energy)), residual: engine.real(this.result + bytesOf(this.f.residual)),
    };
  }

  /** Bounds [N] of the errors of the forces of the last set(), of a model those of its full level; null where there is none:
   * outside of the trained range, several tools of a model, too close together, or without `phynness calibrate`. */
  bounds(): (number | null)[] {
    const { engine } = this;
    this.alive();
    const ofModel = this.f === functions.model;
    const those = ofModel ? [this.tools] : [this.data, this.held];
    const status = ofModel && this.held !== 1 ? undefinedHere : engine.f[this.f.bound]!(this.of, ...those, this.boundsAt);
    if (status !== undefinedHere && status < 0) throw engine.error(status, 'bounds');
    const bounds = Array.from(engine.reals(this.boundsAt, this.held));
    return bounds.map((bound) => (status === undefinedHere || bound >= noBound ? null : bound));
  }

  /** Displacements [m], n x 3, under the tools of the last set(): of all output nodes of a model, of all nodes of a body. */
  deform(out?: Float64Array): Float64Array {
    this.alive();
    this.engine.call(this.f.field, this.of, this.data, this.out);
    return copied(this.engine.reals(this.out, 3 * this.nField), out);
  }
}
