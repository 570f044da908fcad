// The surface of a model, subdivided by Loop's scheme, for drawing.
import { bytesOf, copied, integer, Owner, type Engine } from './engine.js';

export class Surface extends Owner {
  protected readonly what = 'surface';
  readonly nVertices: number;
  /** n x 3, normals outward */
  readonly triangles: Int32Array;
  /** nVertices x 3, undeformed [m] */
  readonly points: Float32Array;
  private readonly surface: number;
  private readonly scratch: number;
  private readonly field: number;
  private readonly out: number;

  constructor(
    engine: Engine,
    parent: Owner,
    model: number,
    levels: number,
    private readonly nOutput: number,
  ) {
    super(engine, parent);
    integer(levels);
    this.surface = this.made('phn_surface', model, levels);
    const contents = this.take(bytesOf('phn_surface_contents'));
    engine.call('phn_surface_info', this.surface, contents);
    const { nVertices, nTriangles, scratchBytes } = engine.read<Record<'nVertices' | 'nTriangles' | 'scratchBytes', number>>('phn_surface_contents', contents);
    this.nVertices = nVertices;
    this.triangles = engine.integers(engine.size(contents + bytesOf('phn_surface_contents.triangles')), 3 * nTriangles).slice();
    this.points = engine.floats(engine.size(contents + bytesOf('phn_surface_contents.points')), 3 * nVertices).slice();
    this.scratch = this.take(scratchBytes);
    this.field = this.take(24 * nOutput);
    this.out = this.take(12 * this.nVertices);
  }

  /** Displacements [m] of all vertices, n x 3. @param field  of Model.deform, Tools.deform or Contact.deform */
  deform(field: Float64Array, out?: Float32Array): Float32Array {
    this.alive();
    if (field.length !== 3 * this.nOutput)
      throw new RangeError(`the field has ${field.length} numbers instead of ${3 * this.nOutput}`);
    this.engine.reals(this.field, field.length).set(field);
    this.engine.call('phn_surface_deform', this.surface, this.scratch, this.field, this.out);
    return copied(this.engine.floats(this.out, 3 * this.nVertices), out);
  }
}
