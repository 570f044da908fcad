// A reduced body, which answers for coupled tools and spheres in place of a model.
import { bytesOf, integer, loaded, Owner, type Engine } from './engine.js';

export interface BodyInfo {
  readonly meshHash: string;
  readonly physicsHash: string;
  readonly law: string;
  /** [m]; 0: node probes */
  readonly toolRadius: number;
  /** largest displacement of the training data [m] */
  readonly maxDisplacement: number;
  readonly nModes: number;
  readonly nCells: number;
}

export class Body extends Owner {
  protected readonly what = 'body';
  readonly info: BodyInfo;
  private readonly body: number;

  constructor(engine: Engine, parent: Owner, text: Uint8Array) {
    super(engine, parent);
    try {
      const { memory, object } = loaded(engine, 'body', text);
      this.own(memory);
      this.body = object;
      const info = engine.heap.take(bytesOf('phn_body_info'));
      try {
        engine.call('phn_body_describe', object, info);
        const textAt = (member: Parameters<typeof bytesOf>[0]) => engine.text(engine.size(info + bytesOf(member)));
        this.info = Object.freeze({
          meshHash: textAt('phn_body_info.mesh_hash'),
          physicsHash: textAt('phn_body_info.physics_hash'),
          law: textAt('phn_body_info.law'),
          toolRadius: engine.real(info + bytesOf('phn_body_info.tool_radius_m')),
          maxDisplacement: engine.real(info + bytesOf('phn_body_info.max_displacement_m')),
          nModes: engine.integer(info + bytesOf('phn_body_info.n_modes')),
          nCells: engine.integer(info + bytesOf('phn_body_info.n_cells')),
        });
      } finally {
        engine.heap.give(info);
      }
    } catch (error) {
      this.dispose();
      throw error;
    }
  }

  /** For Touching.attach. */
  attachment(engine: Engine, data: number, max: number, steps: number): Attachment {
    this.alive();
    if (engine !== this.engine) throw new Error('this body was loaded by another model');
    return new Attachment(engine, this, this.body, data, max, steps);
  }
}

/** The state of a body under some tools. */
class Attachment extends Owner {
  protected readonly what = 'attachment';

  constructor(engine: Engine, parent: Owner, body: number, data: number, max: number, steps: number) {
    super(engine, parent);
    try {
      engine.call('phn_body_attach', data, body, this.made('phn_body_state', body, max), integer(steps));
    } catch (error) {
      this.dispose();
      throw error;
    }
  }
  check(): void {
    this.alive();
  }
}

/** Several tools or spheres, for which a body may answer. */
export abstract class Touching extends Owner {
  protected abstract readonly data: number;
  protected abstract readonly max: number;
  private attached: Attachment | null = null;

  /** From here on the body answers, with at most so many of its steps for one call; null: the model again. */
  attach(body: Body | null, steps = 12): void {
    super.alive();
    const { engine, data } = this;
    const attached = body && body.attachment(engine, data, this.max, steps);
    if (!attached) engine.call('phn_body_attach', data, 0, 0, 0);
    this.attached?.dispose();
    this.attached = attached;
  }
  protected override alive(): void {
    super.alive();
    this.attached?.check();
  }
  override dispose(): void {
    this.attached?.dispose();
    super.dispose();
  }
}
