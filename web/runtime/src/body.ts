// A reduced body, which answers for several tools and spheres.
import { BodyContact, type Contact } from './contact.js';
import { bytesOf, integer, loaded, Owner, type Engine } from './engine.js';
import { BodyTools, type Tools } from './tools.js';

export interface BodyInfo {
  readonly meshHash: string;
  readonly physicsHash: string;
  readonly law: string;
  /** [m]; 0: node probes */
  readonly toolRadius: number;
  /** largest displacement of the training data [m] */
  readonly maxDisplacement: number;
  /** of the surface, ascending numbers in the mesh */
  readonly nodes: Int32Array;
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
          nodes: engine.integers(engine.size(info + bytesOf('phn_body_info.nodes')), engine.integer(info + bytesOf('phn_body_info.n_nodes'))).slice(),
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

  /** Up to 8 tools at the same time, each set() of which makes at most so many of Newton's steps. */
  tools(max: number, steps = 12): Tools {
    this.alive();
    return new BodyTools(this.engine, this, this.body, max, this.info.nodes.length, positive(steps));
  }
  /** Up to 8 spheres that touch, slide and grasp, with at most so many steps for all of them together. */
  contact(max: number, steps = 12): Contact {
    this.alive();
    return new BodyContact(this.engine, this, this.body, max, this.info.nodes.length, positive(steps));
  }
}

function positive(steps: number): number {
  if (integer(steps) < 1) throw new RangeError(`${steps} is not a number of steps`);
  return steps;
}
