// The picture of a body: its surface with light and colours, seen by a camera. The page adds its own objects to `scene`.
import {
  BufferAttribute, BufferGeometry, Color, DirectionalLight, DynamicDrawUsage, Group, HemisphereLight, Mesh,
  MeshStandardMaterial, PerspectiveCamera, Scene, WebGLRenderer,
} from 'three';
import { angleOfView, frameOf, type Camera, type Size } from './camera.js';

/** Colour of a body without a map, in linear light. */
export const tissue: readonly [number, number, number] = [0.5, 0.135, 0.1];
/** Colour of what does not move. */
export const held: readonly [number, number, number] = [0.16, 0.18, 0.21];
/** Colour where a map has no value. */
export const unknown: readonly [number, number, number] = [0.36, 0.36, 0.36];

export class BodyPicture {
  readonly scene = new Scene();
  readonly objects = new Group();
  private readonly renderer: WebGLRenderer;
  private readonly eye = new PerspectiveCamera((angleOfView * 180) / Math.PI, 1, 0.01, 10);
  private readonly material = new MeshStandardMaterial({ vertexColors: true, roughness: 0.62, metalness: 0 });
  private readonly body: Mesh<BufferGeometry, MeshStandardMaterial>;
  private readonly key = new DirectionalLight(0xffffff, 2.3);
  private readonly sky = new HemisphereLight(0xffffff, 0x7a6a66, 1.25);
  private size_: Size = { width: 1, height: 1 };

  /** @throws Error if the browser has no WebGL 2 */
  constructor(readonly canvas: HTMLCanvasElement) {
    this.renderer = new WebGLRenderer({ canvas, antialias: true, alpha: true, powerPreference: 'high-performance' });
    this.renderer.setClearColor(new Color(0), 0);
    // What lies on the surface is drawn over it.
    this.material.polygonOffset = true;
    this.material.polygonOffsetFactor = 1;
    this.material.polygonOffsetUnits = 1;
    this.body = new Mesh(new BufferGeometry(), this.material);
    this.body.frustumCulled = false;
    this.scene.add(this.body, this.objects, this.sky, this.key, this.key.target);
  }

  get size(): Size {
    return this.size_;
  }
  /** Size of the canvas in CSS pixels; true if it changed. */
  resize(width: number, height: number, ratio = Math.min(2, globalThis.devicePixelRatio || 1)): boolean {
    const size = { width: Math.max(1, Math.round(width)), height: Math.max(1, Math.round(height)) };
    if (size.width === this.size_.width && size.height === this.size_.height && ratio === this.renderer.getPixelRatio()) return false;
    this.size_ = size;
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(size.width, size.height, false);
    return true;
  }

  /** A new surface. @param triangles  n x 3, normals outward */
  setSurface(nVertices: number, triangles: Int32Array): void {
    this.body.geometry.dispose();
    const geometry = new BufferGeometry();
    for (const name of ['position', 'normal', 'color'])
      geometry.setAttribute(name, new BufferAttribute(new Float32Array(3 * nVertices), 3).setUsage(DynamicDrawUsage));
    geometry.setIndex(new BufferAttribute(Uint32Array.from(triangles), 1));
    this.body.geometry = geometry;
  }
  /** Positions of all vertices, n x 3 [m]; to be changed in place, then call positionsChanged. */
  get positions(): Float32Array {
    return this.attribute('position').array as Float32Array;
  }
  /** Colours of all vertices in linear light, n x 3; to be changed in place, then call coloursChanged. */
  get colours(): Float32Array {
    return this.attribute('color').array as Float32Array;
  }
  positionsChanged(): void {
    this.body.geometry.computeVertexNormals();
    this.attribute('position').needsUpdate = true;
  }
  coloursChanged(): void {
    this.attribute('color').needsUpdate = true;
  }
  /** With a map, light varies less, so that its colours can be compared with the legend. */
  set flatLight(flat: boolean) {
    this.key.intensity = flat ? 0.9 : 2.3;
    this.sky.intensity = flat ? 2.3 : 1.25;
    this.material.roughness = flat ? 0.95 : 0.62;
  }

  render(camera: Camera): void {
    const { eye, forward, right, up } = frameOf(camera);
    this.eye.aspect = this.size_.width / this.size_.height;
    this.eye.near = camera.distance / 100;
    this.eye.far = camera.distance * 20;
    this.eye.up.set(0, 0, 1);
    this.eye.position.set(...eye);
    this.eye.lookAt(...camera.target);
    this.eye.updateProjectionMatrix();
    // The key light comes from above the left shoulder of the viewer.
    this.key.position.set(
      eye[0] - 0.5 * camera.distance * right[0] + 0.7 * camera.distance * up[0],
      eye[1] - 0.5 * camera.distance * right[1] + 0.7 * camera.distance * up[1],
      eye[2] - 0.5 * camera.distance * right[2] + 0.7 * camera.distance * up[2],
    );
    this.key.target.position.set(eye[0] + forward[0] * camera.distance, eye[1] + forward[1] * camera.distance, eye[2] + forward[2] * camera.distance);
    this.renderer.render(this.scene, this.eye);
  }

  private attribute(name: string): BufferAttribute {
    return this.body.geometry.getAttribute(name) as BufferAttribute;
  }
}
