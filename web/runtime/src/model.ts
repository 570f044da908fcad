// A trained model and its working memory.
import { Body } from './body.js';
import { Contact } from './contact.js';
import { bytesOf, bytesOfText, copied, Engine, integer, Owner, type ModelText } from './engine.js';
import { undefinedHere, warningsOf, type Warning } from './status.js';
import { Surface } from './surface.js';
import { putTool, putVector, toolAt, toolFrom, type Place, type Tool, type Vector } from './tool.js';
import { Tools } from './tools.js';

/** Where a model comes from; '' and 0: not recorded. */
export interface Provenance {
  readonly meshHash: string;
  readonly physicsHash: string;
  readonly element: string;
  /** at rest, of the body that was trained [Pa] */
  readonly shearModulus: number;
  /** distance of the finite elements' forces from those of a finer solution: its name, nodes, probes, tool [m], fractions */
  readonly reference: string;
  readonly finerNodes: number;
  readonly finerProbes: number;
  readonly finerToolRadius: number;
  readonly finerMean: number;
  readonly finerP95: number;
  /** bounds are of the error from 0: these finite elements; 1: taylor-hood; 2: half-size */
  readonly boundReference: number;
}

/** Contents of a model: copies, which stay valid. Nodes are numbers of the mesh; points are n x 3 [m]. */
export interface Info {
  readonly family: string;
  readonly title: string;
  readonly meshHash: string;
  /** largest displacement of the training data [m] */
  readonly maxDisplacement: number;
  readonly nNodes: number;
  readonly activeNodes: Int32Array;
  readonly outputNodes: Int32Array;
  readonly fixedNodes: Int32Array;
  readonly outputPoints: Float64Array;
  readonly fixedPoints: Float64Array;
  /** n x 3; 0 ... outputNodes.length - 1: output nodes, then fixed nodes */
  readonly triangles: Int32Array;
  readonly fields: readonly { readonly name: string; readonly unit: string }[];
  readonly hasEnergy: boolean;
  readonly provenance: Provenance;
}

export interface Level {
  readonly forceCenters: number;
  readonly deformationCenters: number;
  readonly modes: number;
  /** estimated inside the trained range, fractions of the largest force and displacement; 0: no estimate */
  readonly errorForce: number;
  readonly errorDisplacement: number;
}

export interface Response {
  readonly status: number;
  readonly warnings: readonly Warning[];
  /** on the object [N]; a haptic device renders its negative */
  readonly force: Float64Array;
  /** [J] */
  readonly energy?: number;
  /** 3 x 3 [N/m] */
  readonly stiffness?: Float64Array;
}

/** Offsets of the small arguments in one block. */
const at = { tool: 0, force: 72, energy: 96, stiffness: 104, out: 176, x: 184 };
const argumentBytes = 208;

export class Model extends Owner {
  protected readonly what = 'model';
  readonly info: Info;
  readonly levels: readonly Level[];
  private readonly model: number;
  private readonly data: number;
  private readonly args: number;
  private readonly field_: number;
  private level_: number;

  /** @param text  contents of model.txt. @throws PhynnessError with the reason and the byte if it is refused */
  static async create(module: WebAssembly.Module, text: Uint8Array): Promise<Model> {
    return new Model(await Engine.of(module), text);
  }
  private constructor(engine: Engine, text: Uint8Array) {
    super(engine);
    this.model = this.loaded('model', text);
    this.data = this.made('phn_data', this.model, 1);
    this.args = this.take(argumentBytes);
    const info = this.take(bytesOf('phn_info')), level = this.take(bytesOf('phn_level'));
    engine.call('phn_model_info', this.model, info);
    this.info = infoAt(engine, info);
    this.field_ = this.take(24 * this.info.outputNodes.length);
    this.levels = Array.from({ length: engine.integer(info + bytesOf('phn_info.n_levels')) }, (_, i) => {
      engine.call('phn_level_info', this.model, i, level);
      return engine.read<Level>('phn_level', level);
    });
    this.level_ = this.levels.length - 1;
  }

  /** Force at a node or place that is displaced by d [m]; on request energy and stiffness (not in family rbfn). */
  force(place: number | Place, d: Vector, also: { energy?: boolean; stiffness?: boolean } = {}): Response {
    const { engine, args } = this;
    this.put(place, d);
    const status = engine.call('phn_force', this.model, this.data, args + at.tool, args + at.force,
      also.energy ? args + at.energy : 0, also.stiffness ? args + at.stiffness : 0);
    return {
      status,
      warnings: warningsOf(status),
      force: engine.reals(args + at.force, 3).slice(),
      ...(also.energy ? { energy: engine.real(args + at.energy) } : {}),
      ...(also.stiffness ? { stiffness: engine.reals(args + at.stiffness, 9).slice() } : {}),
    };
  }

  /** Displacements [m] of all output nodes, n x 3, with one tool. @param out  is filled and returned */
  deform(place: number | Place, d: Vector, out?: Float64Array): Float64Array {
    this.put(place, d);
    this.engine.call('phn_deform', this.model, this.data, this.args + at.tool, this.field_);
    return copied(this.engine.reals(this.field_, 3 * this.info.outputNodes.length), out);
  }

  /** Values of a scalar field at all output nodes. @param field  index of info.fields, or its name */
  field(place: number | Place, d: Vector, field: number | string, out?: Float64Array): Float64Array {
    this.put(place, d);
    const index = typeof field === 'number' ? field : this.info.fields.findIndex((f) => f.name === field);
    this.engine.call('phn_field', this.model, this.data, this.args + at.tool, integer(index), this.field_);
    return copied(this.engine.reals(this.field_, this.info.outputNodes.length), out);
  }

  /** Depth [m] of the trained range in the direction of d; at rest the smallest of all directions. */
  trainedDepth(place: number | Place, d: Vector): number {
    const { engine, args } = this;
    this.put(place, d);
    engine.call('phn_depth', this.model, args + at.tool, args + at.out);
    return engine.real(args + at.out);
  }

  /** Bound [N] of the error of a force; null where the model has none: outside of the trained range, or without `phynness calibrate`. */
  bound(place: number | Place, d: Vector): number | null {
    const { engine, args } = this;
    this.put(place, d);
    const status = engine.f['phn_bound']!(this.model, args + at.tool, args + at.out);
    if (status === undefinedHere || warningsOf(status).includes('outside')) return null;
    if (status < 0) throw engine.error(status, 'phn_bound');
    return engine.real(args + at.out);
  }

  /** The tool at the place, of those that can be touched, nearest to x [m], its point, and the distance [m], < 0 inside. */
  nearest(x: Vector): { tool: Tool; point: Float64Array; distance: number } {
    const { engine, args } = this;
    this.alive();
    putVector(engine, args + at.x, x, 'the point');
    engine.call('phn_nearest', this.model, args + at.x, args + at.tool, args + at.force, args + at.out);
    return { tool: toolFrom(engine, args + at.tool), point: engine.reals(args + at.force, 3).slice(), distance: engine.real(args + at.out) };
  }

  /** Level of force, deform and field: index of `levels`; the last one is the full model. */
  get level(): number {
    return this.level_;
  }
  set level(level: number) {
    this.alive();
    this.engine.call('phn_set_level', this.model, this.data, integer(level));
    this.level_ = level;
  }

  /** Up to 8 tools at the same time. It cannot be used after dispose() of this model. */
  tools(max: number): Tools {
    this.alive();
    return new Tools(this.engine, this, this.model, max, this.info.outputNodes.length, null);
  }
  /** A reduced body, in the memory of this model. @param text  contents of body.txt */
  body(text: ModelText): Body {
    this.alive();
    return new Body(this.engine, this, bytesOfText(text));
  }
  /** The surface subdivided 0 to 6 times, for drawing. */
  surface(levels: number): Surface {
    this.alive();
    return new Surface(this.engine, this, this.model, levels, this.info.outputNodes.length);
  }
  /** Up to 8 spheres that touch, slide and grasp. */
  contact(max: number): Contact {
    this.alive();
    return new Contact(this.engine, this, this.model, max, this.info.outputNodes.length, null);
  }

  private put(place: number | Place, displacement: Vector): void {
    this.alive();
    const tool = typeof place === 'number' ? toolAt(place, displacement) : { nodes: place.nodes, weights: place.weights, displacement };
    putTool(this.engine, this.args + at.tool, tool);
  }
}

function infoAt(engine: Engine, at: number): Info {
  const { nOutput, nFixed, nActive, nTriangles, nFields, hasEnergy, nLevels, ...info } = engine.read<
    Info & Record<'nOutput' | 'nFixed' | 'nActive' | 'nTriangles' | 'nFields' | 'nLevels', number>>('phn_info', at);
  const pointer = (member: 'active_nodes' | 'output_nodes' | 'fixed_nodes' | 'output_points' | 'fixed_points' | 'triangles') =>
    engine.size(at + bytesOf(`phn_info.${member}`));
  return Object.freeze({
    ...info,
    activeNodes: engine.integers(pointer('active_nodes'), nActive).slice(),
    outputNodes: engine.integers(pointer('output_nodes'), nOutput).slice(),
    fixedNodes: engine.integers(pointer('fixed_nodes'), nFixed).slice(),
    outputPoints: engine.reals(pointer('output_points'), 3 * nOutput).slice(),
    fixedPoints: engine.reals(pointer('fixed_points'), 3 * nFixed).slice(),
    triangles: engine.integers(pointer('triangles'), 3 * nTriangles).slice(),
    fields: Array.from({ length: nFields }, (_, i) => ({
      name: engine.text(engine.size(at + bytesOf('phn_info.field_names') + 4 * i)),
      unit: engine.text(engine.size(at + bytesOf('phn_info.field_units') + 4 * i)),
    })),
    hasEnergy: Boolean(hasEnergy),
    provenance: engine.read<Provenance>('phn_provenance', at + bytesOf('phn_info.provenance')),
  });
}
