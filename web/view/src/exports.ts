// Files that the page writes: the picture as PNG, the displaced surface as glTF.
import { BufferAttribute, BufferGeometry, Mesh, MeshStandardMaterial } from 'three';
import { GLTFExporter } from 'three/examples/jsm/exporters/GLTFExporter.js';
import { cssColour } from '../../shared/src/colour_maps.js';
import { normalsOf } from '../../shared/src/normals.js';
import { plain, roundedDown, shown, significant, ticks } from '../../shared/src/numbers.js';
import type { Scale } from '../../shared/src/legend.js';
import { norm } from '../../shared/src/vectors.js';
import { nameOf } from './places.js';
import type { Session } from './session.js';

/** The bytes of a .glb file (binary glTF 2.0): the displaced surface with its colours; its morph target is the undeformed shape.
 * Units are metres, as in the model. */
export async function glbOf(session: Session, positions: Float32Array, colours: Float32Array): Promise<Uint8Array<ArrayBuffer>> {
  const { runtime, state, answer } = session, { info } = runtime.model, surface = runtime.surface(state.subdivision);
  const rows = (numbers: Float32Array) => new BufferAttribute(numbers, 3), geometry = new BufferGeometry();
  geometry.setAttribute('position', rows(positions));
  geometry.setAttribute('normal', rows(normalsOf(positions, surface.triangles, new Float32Array(positions.length))));
  geometry.setAttribute('color', rows(colours));
  geometry.setIndex(new BufferAttribute(Uint32Array.from(surface.triangles), 1));
  geometry.morphTargetsRelative = true;
  geometry.morphAttributes = { position: [Object.assign(rows(surface.points.map((x, i) => x - positions[i]!)), { name: 'rest' })] };
  const mesh = new Mesh(geometry, new MeshStandardMaterial({ vertexColors: true, metalness: 0, roughness: 0.6 }));
  mesh.name = plain(info.title);
  mesh.userData = {
    unit: 'm',
    tools: state.mode === 'hold' ? state.tools.map(({ place, displacement }, i) => ({
      nodes: place.nodes, weights: place.weights, displacement_m: displacement, force_N: answer.forces[i] ?? null,
    })) : [],
  };
  return new Uint8Array(await new GLTFExporter().parseAsync(mesh, { binary: true }) as ArrayBuffer);
}

/** The picture with its title, figures and legend. The canvas must have been drawn in the same task. */
export function pngOf(canvas: HTMLCanvasElement, session: Session, legend: Scale | null, pixelSize: number): Promise<Blob | null> {
  const page = getComputedStyle(document.documentElement), colour = (name: string) => page.getPropertyValue(name).trim();
  const ratio = canvas.width / (canvas.clientWidth || 1), strip = Math.round(34 * ratio);
  const out = document.createElement('canvas');
  out.width = canvas.width;
  out.height = canvas.height + strip;
  const draw = out.getContext('2d')!;
  draw.fillStyle = colour('--stage');
  draw.fillRect(0, 0, out.width, out.height);
  draw.drawImage(canvas, 0, strip);
  draw.scale(ratio, ratio);
  draw.fillStyle = colour('--ink');
  draw.font = '14px system-ui, sans-serif';
  draw.textBaseline = 'middle';
  const width = out.width / ratio, height = out.height / ratio;
  draw.fillText(captionOf(session), 12, 18, width - 24);
  const bar = roundedDown(150 * pixelSize), pixels = pixelSize > 0 ? bar / pixelSize : 0;
  if (bar > 0) {
    draw.fillRect(width - pixels - 16, height - 16, pixels, 2);
    draw.textAlign = 'right';
    draw.fillText(`${significant(1e3 * bar, 2)} mm`, width - 16, height - 28);
    draw.textAlign = 'left';
  }
  if (legend) drawLegend(draw, legend, height);
  return new Promise((resolve) => out.toBlob(resolve, 'image/png'));
}

function drawLegend(draw: CanvasRenderingContext2D, scale: Scale, height: number): void {
  const { unit, factor } = shown(scale.unit, scale.high), left = 16, top = height - 62, length = 240;
  draw.fillText(`${scale.title} [${unit}]`, left, top);
  const bar = draw.createLinearGradient(left, 0, left + length, 0), ink = draw.fillStyle;
  for (let i = 0; i <= 16; ++i) bar.addColorStop(i / 16, cssColour(i / 16));
  draw.fillStyle = bar;
  draw.fillRect(left, top + 12, length, 12);
  draw.fillStyle = ink;
  draw.textAlign = 'center';
  for (const value of ticks(scale.low * factor, scale.high * factor, 4))
    draw.fillText(String(Number(value.toPrecision(3))), left + (length * (value / factor - scale.low)) / (scale.high - scale.low || 1), top + 36);
  draw.textAlign = 'left';
}

function captionOf({ runtime, state, answer }: Session): string {
  const forces = answer.forces.map((force) => `${significant(norm(force), 4)} N`);
  const tools = state.mode === 'sphere' ? [`sphere ${forces[0] ?? ''}`] : state.tools.map(({ place, displacement }, i) =>
    `${nameOf(place)}: ${significant(1e3 * norm(displacement), 3)} mm, ${forces[i]}`);
  return [plain(runtime.model.info.title, 90), ...tools].join('   ');
}
