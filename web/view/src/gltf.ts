// A displaced surface as a binary glTF 2.0 file (GLB): positions and normals as they are now, and morph targets that lead to
// other shapes. Units are metres, as in the model.
import { BufferAttribute, BufferGeometry, Mesh, MeshStandardMaterial } from 'three';
import { GLTFExporter } from 'three/examples/jsm/exporters/GLTFExporter.js';
import { normalsOf } from '../../shared/src/normals.js';

export interface Shape {
  readonly name: string;
  /** displacement of every vertex from the present state [m], n x 3 */
  readonly offset: Float32Array;
}
export interface Picture {
  readonly title: string;
  /** present positions [m], n x 3 */
  readonly positions: Float32Array;
  /** n x 3, normals outward */
  readonly triangles: Int32Array;
  /** red, green and blue of every vertex, linear, 0 ... 1 */
  readonly colors: Float32Array;
  readonly shapes: readonly Shape[];
  /** extras of the node, for example node, displacement and force */
  readonly facts: Readonly<Record<string, unknown>>;
}

/** The bytes of a .glb file. */
export async function glb({ title, positions, triangles, colors, shapes, facts }: Picture): Promise<Uint8Array<ArrayBuffer>> {
  const rows = (numbers: Float32Array) => new BufferAttribute(numbers, 3), geometry = new BufferGeometry();
  geometry.setAttribute('position', rows(positions));
  geometry.setAttribute('normal', rows(normalsOf(positions, triangles, new Float32Array(positions.length))));
  geometry.setAttribute('color', rows(colors));
  geometry.setIndex(new BufferAttribute(Uint32Array.from(triangles), 1));
  geometry.morphTargetsRelative = true;
  geometry.morphAttributes = { position: shapes.map(({ name, offset }) => Object.assign(rows(offset), { name })) };
  const mesh = new Mesh(geometry, new MeshStandardMaterial({ vertexColors: true, metalness: 0, roughness: 0.6 }));
  mesh.name = title;
  mesh.userData = facts;
  return new Uint8Array(await new GLTFExporter().parseAsync(mesh, { binary: true }) as ArrayBuffer);
}
