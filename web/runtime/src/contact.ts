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

export abstract class Contact extends Owner {
  protected readonly what = 'contact';
  protected readonly contact: number;
  /** what answers for the spheres */
  protected readonly data: number;
  protected readonly tools: number;
  protected readonly states: number;
  protected readonly result: number;
  protected readonly out: number;

  /** @param of  the model or the body. @param nField  nodes of a field */
  constructor(
    engine: Engine,
    parent: Owner,
    protected readonly of: number,
    private readonly max: number,
    private readonly nField: number,
    names: { contact: string; data: string; resultBytes: number },
  ) {
    super(engine, parent);
    few(max);
    try {
      this.contact = this.made(names.contact, of, max);
      this.data = this.made(names.data, of, max);
      this.tools = this.take(max * bytesOf('phn_contact_tool'));
      this.states = this.take(max * bytesOf('phn_contact_state'));
      this.result = this.take(names.resultBytes);
      this.out = this.take(24 * nField);
    } catch (error) {
      this.dispose();
      throw error;
    }
  }
  /** Calls of the runtime. @returns the status */
  protected abstract move(n: number): number;
  protected abstract field(): void;
  protected abstract energy(): number;

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
    const status = this.move(spheres.length);
    return {
      status,
      warnings: warningsOf(status),
      energy: this.energy(),
      touches: spheres.map((_, i) => this.touch(this.states + i * bytesOf('phn_contact_state'))),
    };
  }

  /** Displacements [m], n x 3, of the last step(): of all output nodes of a model, of all nodes of a body. */
  deform(out?: Float64Array): Float64Array {
    this.alive();
    this.field();
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
    const { engine } = this;
    const inContact = engine.integer(at + bytesOf('phn_contact_state.in_contact')) === 1;
    return {
      inContact,
      force: engine.reals(at + bytesOf('phn_contact_state.force'), 3).slice(),
      proxy: engine.reals(at + bytesOf('phn_contact_state.proxy'), 3).slice(),
      normal: engine.reals(at + bytesOf('phn_contact_state.normal'), 3).slice(),
      scale: engine.real(at + bytesOf('phn_contact_state.scale')),
      unbalanced: engine.real(at + bytesOf('phn_contact_state.unbalanced')),
      held: inContact ? toolFrom(engine, at + bytesOf('phn_contact_state.held')) : null,
    };
  }
}

export class ModelContact extends Contact {
  constructor(engine: Engine, parent: Owner, model: number, max: number, nOutput: number) {
    super(engine, parent, model, max, nOutput, { contact: 'phn_contact', data: 'phn_tools', resultBytes: bytesOf('phn_coupled') });
  }
  protected move(n: number): number {
    return this.engine.call('phn_contact_step', this.contact, this.data, n, this.tools, this.states, this.result);
  }
  protected field(): void {
    this.engine.call('phn_coupled_deform', this.of, this.data, this.out);
  }
  protected energy(): number {
    return this.engine.real(this.result + bytesOf('phn_coupled.energy'));
  }
}

export class BodyContact extends Contact {
  constructor(engine: Engine, parent: Owner, body: number, max: number, nNodes: number, private readonly steps: number) {
    super(engine, parent, body, max, nNodes, { contact: 'phn_body_contact', data: 'phn_body_state', resultBytes: bytesOf('phn_body_pressed') });
  }
  protected move(n: number): number {
    return this.engine.call('phn_body_contact_step', this.contact, this.data, this.steps, n, this.tools, this.states, this.result);
  }
  protected field(): void {
    this.engine.call('phn_body_deform', this.of, this.data, this.out);
  }
  protected energy(): number {
    return this.engine.real(this.result + bytesOf('phn_body_pressed.energy'));
  }
}
