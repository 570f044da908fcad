// A displaced surface as a binary glTF 2.0 file (GLB): positions and normals as they are now, and morph targets that lead to
// other shapes, the first one back to rest. Units are metres, as in the model.

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
  readonly colors?: Float32Array;
  readonly shapes?: readonly Shape[];
  /** extras of the mesh, for example node, displacement and force */
  readonly facts?: Readonly<Record<string, unknown>>;
}

const float = 5126, unsignedInt = 5125, unsignedByte = 5121;
const vertices = 34962, indices = 34963;

/** Normals for glTF, which have the length 1: (0, 0, 1) where there is none. */
function unitNormals(positions: Float32Array, triangles: Int32Array): Float32Array {
  const normals = normalsOf(positions, triangles, new Float32Array(positions.length));
  for (let i = 0; i < normals.length; i += 3)
    if (normals[i] === 0 && normals[i + 1] === 0 && normals[i + 2] === 0) normals[i + 2] = 1;
  return normals;
}

/** Smallest and largest component along each axis. */
function bounds(rows: Float32Array): { min: number[]; max: number[] } {
  const min = [Infinity, Infinity, Infinity], max = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < rows.length; ++i) {
    min[i % 3] = Math.min(min[i % 3]!, rows[i]!);
    max[i % 3] = Math.max(max[i % 3]!, rows[i]!);
  }
  return { min, max };
}

/** The bytes of a .glb file. */
export function glb(picture: Picture): Uint8Array {
  const { positions, triangles, colors, shapes = [] } = picture;
  const n = positions.length / 3;
  for (const { name, offset } of shapes)
    if (offset.length !== positions.length) throw new RangeError(`shape ${name} has ${offset.length} numbers`);
  const parts: Uint8Array[] = [], bufferViews: object[] = [], accessors: object[] = [];
  let length = 0;
  // All parts have a multiple of 4 bytes.
  const accessor = (data: Float32Array | Uint32Array | Uint8Array, target: number, about: object): number => {
    const bytes = new Uint8Array(data.buffer, data.byteOffset, data.byteLength);
    bufferViews.push({ buffer: 0, byteOffset: length, byteLength: bytes.length, target });
    parts.push(bytes);
    length += bytes.length;
    return accessors.push({ bufferView: bufferViews.length - 1, ...about }) - 1;
  };
  const points = (rows: Float32Array, count: number) =>
    accessor(rows, vertices, { componentType: float, count, type: 'VEC3', ...bounds(rows) });
  const attributes: Record<string, number> = { POSITION: points(positions, n) };
  attributes['NORMAL'] = accessor(unitNormals(positions, triangles), vertices, { componentType: float, count: n, type: 'VEC3' });
  if (colors) {
    const rgba = new Uint8Array(4 * n).fill(255);
    for (let i = 0; i < n; ++i)
      for (let k = 0; k < 3; ++k) rgba[4 * i + k] = Math.round(255 * Math.min(1, Math.max(0, colors[3 * i + k]!)));
    attributes['COLOR_0'] = accessor(rgba, vertices, { componentType: unsignedByte, normalized: true, count: n, type: 'VEC4' });
  }
  const index = accessor(Uint32Array.from(triangles), indices,
    { componentType: unsignedInt, count: triangles.length, type: 'SCALAR' });
  const targets = shapes.map(({ offset }) => ({ POSITION: points(offset, n) }));
  const json = {
    asset: { version: '2.0', generator: 'phynness' },
    scene: 0,
    scenes: [{ nodes: [0] }],
    nodes: [{ name: picture.title, mesh: 0 }],
    materials: [{ pbrMetallicRoughness: { baseColorFactor: colors ? [1, 1, 1, 1] : [0.72, 0.32, 0.28, 1], metallicFactor: 0, roughnessFactor: 0.6 } }],
    meshes: [{
      name: picture.title,
      primitives: [{ attributes, indices: index, material: 0, ...(targets.length > 0 ? { targets } : {}) }],
      ...(targets.length > 0 ? { weights: targets.map(() => 0) } : {}),
      extras: { ...picture.facts, ...(targets.length > 0 ? { targetNames: shapes.map((shape) => shape.name) } : {}) },
    }],
    buffers: [{ byteLength: length }],
    bufferViews,
    accessors,
  };
  const text = new TextEncoder().encode(JSON.stringify(json));
  const textBytes = Math.ceil(text.length / 4) * 4;
  const out = new Uint8Array(12 + 8 + textBytes + 8 + length), words = new DataView(out.buffer);
  const chunk = (at: number, bytes: number, type: number) => {
    words.setUint32(at, bytes, true);
    words.setUint32(at + 4, type, true);
  };
  chunk(0, 0x46546c67, 2);
  words.setUint32(8, out.length, true);
  chunk(12, textBytes, 0x4e4f534a);
  out.fill(0x20, 20, 20 + textBytes);
  out.set(text, 20);
  chunk(20 + textBytes, length, 0x004e4942);
  let at = 28 + textBytes;
  for (const part of parts) {
    out.set(part, at);
    at += part.length;
  }
  return out;
}
