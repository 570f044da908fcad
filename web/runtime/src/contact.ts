// Spheres that touch, slide on, press and grasp the object.
import { bytesOf, copied, few, Owner, type Engine } from './engine.js';
import { warningsOf, type Warning } from './status.js';
import { putVector, toolFrom, type Tool, type Vector } from './tool.js';

const modes = { off: 0, press: 1, grasp: 2 } as const;

export interface Sphere {
  /** position of the device [m] */
  center: Vector;
  /** [m] */
  radius: number;
  /** coefficient of mode press; default 0 */
  friction?: number;
  /** default press */
  mode?: keyof typeof modes;
}

export interface Touch {
  readonly inContact: boolean;
  /** on the object [N]; zeros without contact */
  readonly force: Float64Array;
  /** centre of the sphere on the undeformed surface [m] */
  readonly proxy: Float64Array;
  /** outward; zeros without contact */
  readonly normal: Float64Array;
  /** factor of the force: below 1 where the tool would gain energy */
  readonly scale: number;
  readonly unbalanced: number;
  /** null without contact */
  readonly held: Tool | null;
}

/** The C functions of spheres, and what their result holds. */
const functions = {
  model: { contact: 'phn_contact', data: 'phn_data', step: 'phn_contact_step', field: 'phn_coupled_deform', result: 'phn_coupled',
    energy: 'phn_coupled.energy' },
  body: { contact: 'phn_body_contact', data: 'phn_body_state', step: 'phn_body_contact_step', field: 'phn_body_deform',
    result: 'phn_body_report', energy: 'phn_body_report.energy' },
} as const;

export class Contact extends Owner {
  protected readonly what = 'contact';
  private readonly f: (typeof functions)['model' | 'body'];
  private readonly steps: readonly number[];
  private readonly contact: number;
  /** what answers for the spheres */
  private readonly data: number;
  private readonly tools: number;
  private readonly states: number;
  private readonly result: number;
  private readonly out: number;

  /** @param of  the model or the body. @param nField  nodes of a field. @param steps  of a body for all spheres; null: of a model */
  constructor(engine: Engine, parent: Owner, private readonly of: number, private readonly max: number, private readonly nField: number,
    steps: number | null) {
    super(engine, parent);
    few(max);
    this.f = functions[steps === null ? 'model' : 'body'];
    this.steps = steps === null ? [] : [steps];
    this.contact = this.made(this.f.contact, of, max);
    this.data = this.made(this.f.data, of, max);
    this.tools = this.take(max * bytesOf('phn_contact_tool'));
    this.states = this.take(max * bytesOf('phn_contact_state'));
    this.result = this.take(bytesOf(this.f.result));
    this.out = this.take(24 * nField);
  }

  /** Moves the spheres to new positions. Sphere i is the same sphere in every call. */
  step(spheres: readonly Sphere[]): { status: number; warnings: readonly Warning[]; energy: number; touches: Touch[] } {
    const { engine } = this;
    this.alive();
    if (spheres.length > this.max) throw new RangeError(`${spheres.length} spheres, but this was made for ${this.max}`);
    spheres.forEach((sphere, i) => {
      const mode = sphere.mode ?? 'press';
      if (!Object.hasOwn(modes, mode)) throw new RangeError(`${String(mode)} is not off, press or grasp`);
      const at = this.tools + i * bytesOf('phn_contact_tool');
      putVector(engine, at + bytesOf('phn_contact_tool.center'), sphere.center, 'the centre');
      engine.reals(at + bytesOf('phn_contact_tool.radius'), 1)[0] = sphere.radius;
      engine.reals(at + bytesOf('phn_contact_tool.friction'), 1)[0] = sphere.friction ?? 0;
      engine.integers(at + bytesOf('phn_contact_tool.mode'), 1)[0] = modes[mode];
    });
    const status = engine.call(this.f.step, this.contact, this.data, ...this.steps, spheres.length, this.tools, this.states, this.result);
    return {
      status,
      warnings: warningsOf(status),
      energy: engine.real(this.result + bytesOf(this.f.energy)),
      touches: spheres.map((_, i) => this.touch(this.states + i * bytesOf('phn_contact_state'))),
    };
  }

  /** Displacements [m], n x 3, of the last step(): of all output nodes of a model, of all nodes of a body. */
  deform(out?: Float64Array): Float64Array {
    this.alive();
    this.engine.call(this.f.field, this.of, this.data, this.out);
    return copied(this.engine.reals(this.out, 3 * this.nField), out);
  }

  /** Displaces the surface for spheres without contact by a field of deform(); null: the undeformed surface. */
  refit(field: Float64Array | null): void {
    const { engine } = this;
    this.alive();
    if (field && field.length !== 3 * this.nField)
      throw new RangeError(`the field has ${field.length} numbers instead of ${3 * this.nField}`);
    if (field) engine.reals(this.out, field.length).set(field);
    engine.call('phn_contact_refit', this.contact, field ? this.out : 0);
  }

  /** The tool at the point, of those that can be touched, that is nearest to x [m]. */
  nearest(x: Vector): { tool: Tool; point: Float64Array } {
    const { engine } = this;
    this.alive();
    const at = this.states, tool = at + 48;
    putVector(engine, at, x, 'the point');
    engine.call('phn_contact_nearest', this.contact, at, tool, at + 24);
    return { tool: toolFrom(engine, tool), point: engine.reals(at + 24, 3).slice() };
  }

  /** Ends every contact and forgets all positions. */
  reset(): void {
    this.alive();
    this.engine.call('phn_contact_reset', this.contact);
  }

  private touch(at: number): Touch {
    const { engine } = this, { integer, real } = engine.members(at);
    const inContact = integer('phn_contact_state.in_contact') === 1;
    return {
      inContact,
      force: engine.reals(at + bytesOf('phn_contact_state.force'), 3).slice(),
      proxy: engine.reals(at + bytesOf('phn_contact_state.proxy'), 3).slice(),
      normal: engine.reals(at + bytesOf('phn_contact_state.normal'), 3).slice(),
      scale: real('phn_contact_state.scale'),
      unbalanced: real('phn_contact_state.unbalanced'),
      held: inContact ? toolFrom(engine, at + bytesOf('phn_contact_state.held')) : null,
    };
  }
}
