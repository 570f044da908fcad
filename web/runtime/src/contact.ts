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

export class Contact extends Owner {
  protected readonly what = 'contact';
  private readonly contact: number;
  private readonly tools: number;
  private readonly states: number;
  private readonly result: number;
  private readonly out: number;

  /** @param of  the model or the body. @param nField  nodes of a field. @param steps  of a body for all spheres; null: of a model */
  constructor(engine: Engine, parent: Owner, of: number, private readonly max: number, private readonly nField: number, steps: number | null) {
    super(engine, parent);
    few(max);
    this.contact = steps === null ? this.made('phn_contact', of, max) : this.made('phn_body_contact', of, max, steps);
    this.tools = this.take(max * bytesOf('phn_contact_tool'));
    this.states = this.take(max * bytesOf('phn_contact_state'));
    this.result = this.take(bytesOf('phn_contact_report'));
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
      engine.integers(at + bytesOf('phn_contact_tool.mode'), 2).set([modes[mode], 0]); // and the reserved word
    });
    const status = engine.call('phn_contact_step', this.contact, spheres.length, this.tools, this.states, this.result);
    return {
      status,
      warnings: warningsOf(status),
      energy: engine.real(this.result + bytesOf('phn_contact_report.energy')),
      touches: spheres.map((_, i) => this.touch(this.states + i * bytesOf('phn_contact_state'))),
    };
  }

  /** Displacements [m], n x 3, of the last step(): of all output nodes of a model, of all nodes of a body. */
  deform(out?: Float64Array): Float64Array {
    this.alive();
    this.engine.call('phn_contact_deform', this.contact, this.out);
    return copied(this.engine.reals(this.out, 3 * this.nField), out);
  }

  /** Ends every contact and forgets all positions. */
  reset(): void {
    this.alive();
    this.engine.call('phn_contact_reset', this.contact);
  }

  private touch(at: number): Touch {
    const { engine } = this, { inContact, scale, unbalanced } = engine.read<Record<'inContact' | 'scale' | 'unbalanced', number>>('phn_contact_state', at);
    return {
      inContact: inContact === 1,
      force: engine.reals(at + bytesOf('phn_contact_state.force'), 3).slice(),
      proxy: engine.reals(at + bytesOf('phn_contact_state.proxy'), 3).slice(),
      normal: engine.reals(at + bytesOf('phn_contact_state.normal'), 3).slice(),
      scale,
      unbalanced,
      held: inContact === 1 ? toolFrom(engine, at + bytesOf('phn_contact_state.held')) : null,
    };
  }
}
