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
  readonly nTriangles: number;
  readonly nModes: number;
  readonly nPressures: number;
  readonly nCells: number;
}

export class Body extends Owner {
  protected readonly what = 'body';
  readonly info: BodyInfo;
  private readonly body: number;

  constructor(engine: Engine, parent: Owner, text: Uint8Array) {
    super(engine, parent);
    this.body = this.loaded('body', text);
    const info = this.take(bytesOf('phn_body_contents'));
    engine.call('phn_body_info', this.body, info);
    const { nNodes, ...read } = engine.read<BodyInfo & { nNodes: number }>('phn_body_contents', info);
    this.info = Object.freeze({ ...read, nodes: engine.integers(engine.size(info + bytesOf('phn_body_contents.nodes')), nNodes).slice() });
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
