// A reduced body, which answers for several tools and spheres.
import { Contact } from './contact.js';
import { bytesOf, integer as checkedInteger, Owner, type Engine } from './engine.js';
import { Tools } from './tools.js';

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
    this.body = this.loaded('body', text);
    const info = this.take(bytesOf('phn_body_contents')), { text: textOf, integer, pointer, real } = engine.members(info);
    engine.call('phn_body_info', this.body, info);
    this.info = Object.freeze({
      meshHash: textOf('phn_body_contents.mesh_hash'),
      physicsHash: textOf('phn_body_contents.physics_hash'),
      law: textOf('phn_body_contents.law'),
      toolRadius: real('phn_body_contents.tool_radius_m'),
      maxDisplacement: real('phn_body_contents.max_displacement_m'),
      nodes: engine.integers(pointer('phn_body_contents.nodes'), integer('phn_body_contents.n_nodes')).slice(),
      nModes: integer('phn_body_contents.n_modes'),
      nCells: integer('phn_body_contents.n_cells'),
    });
  }

  /** Up to 8 tools at the same time, each set() of which makes at most so many of Newton's steps. */
  tools(max: number, steps = 12): Tools {
    this.alive();
    return new Tools(this.engine, this, this.body, max, this.info.nodes.length, positive(steps));
  }
  /** Up to 8 spheres that touch, slide and grasp, with at most so many steps for all of them together. */
  contact(max: number, steps = 12): Contact {
    this.alive();
    return new Contact(this.engine, this, this.body, max, this.info.nodes.length, positive(steps));
  }
}

function positive(steps: number): number {
  if (checkedInteger(steps) < 1) throw new RangeError(`${steps} is not a number of steps`);
  return steps;
}
