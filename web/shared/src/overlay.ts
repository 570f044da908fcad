// Scale bar and axes beside the picture, drawn as SVG.
import { frameOf, metresPerPixel, type Camera, type Size } from './camera.js';
import { roundedDown, significant } from './numbers.js';
import { dot, type V3 } from './vectors.js';

const svg = 'http://www.w3.org/2000/svg';
const axes: readonly { name: string; direction: V3 }[] = [
  { name: 'x', direction: [1, 0, 0] },
  { name: 'y', direction: [0, 1, 0] },
  { name: 'z', direction: [0, 0, 1] },
];

function part(name: string, attributes: Record<string, string>, parent: Element): SVGElement {
  const element = document.createElementNS(svg, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  parent.append(element);
  return element;
}

/** The axes of the mesh and a bar of round length, true at the distance of the camera's target. */
export class Overlay {
  readonly element = document.createElementNS(svg, 'svg') as SVGSVGElement;
  private readonly lines = axes.map(({ name }) => ({
    line: part('line', { x1: '40', y1: '44', class: `axis axis-${name}` }, this.element),
    text: part('text', { class: 'axis-name', 'text-anchor': 'middle', 'dominant-baseline': 'central' }, this.element),
  }));
  private readonly bar = part('path', { class: 'scale-bar' }, this.element);
  private readonly length = part('text', { x: '96', y: '50', class: 'scale-length' }, this.element);

  constructor() {
    this.element.setAttribute('class', 'overlay');
    this.element.setAttribute('role', 'img');
    this.element.setAttribute('viewBox', '0 0 260 88');
    this.element.setAttribute('width', '260');
    this.element.setAttribute('height', '88');
    axes.forEach(({ name }, i) => (this.lines[i]!.text.textContent = name));
  }

  show(camera: Camera, size: Size): void {
    const { right, up } = frameOf(camera);
    axes.forEach(({ direction }, i) => {
      const x = dot(direction, right), y = -dot(direction, up), { line, text } = this.lines[i]!;
      line.setAttribute('x2', (40 + 24 * x).toFixed(1));
      line.setAttribute('y2', (44 + 24 * y).toFixed(1));
      text.setAttribute('x', (40 + 34 * x).toFixed(1));
      text.setAttribute('y', (44 + 34 * y).toFixed(1));
    });
    const pixel = metresPerPixel(size, camera.distance), metres = roundedDown(150 * pixel), pixels = metres / pixel;
    const name = metres >= 1 ? `${significant(metres, 1)} m` : `${Number((metres * 1e3).toPrecision(2))} mm`;
    this.bar.setAttribute('d', `M96 58v8h${pixels.toFixed(1)}v-8`);
    if (this.length.textContent !== name) {
      this.length.textContent = name;
      this.element.setAttribute('aria-label', `Scale bar: ${name}; axes x, y and z`);
    }
  }
}
