// A colour map that is perceptually even and readable by the colour-blind, computed here; no table of others is used.
// Its colours lie on a curve from dark blue through green to yellow in Oklab (B. Ottosson, "A perceptual color space for
// image processing", 2020), at equal distances along this curve; lightness rises all the way, so that it also reads in grey.

export type Rgb = readonly [number, number, number];
type Lab = readonly [number, number, number];

/** Control points of the Bezier curve: lightness, green-red, blue-yellow. */
const curve: readonly Lab[] = [
  [0.27, 0.02, -0.115],
  [0.52, -0.035, -0.13],
  [0.68, -0.13, 0.06],
  [0.93, -0.035, 0.165],
];

function bezier(t: number): Lab {
  const s = 1 - t, w = [s * s * s, 3 * s * s * t, 3 * s * t * t, t * t * t];
  const at = (k: 0 | 1 | 2) => curve.reduce((sum, point, i) => sum + w[i]! * point[k], 0);
  return [at(0), at(1), at(2)];
}

/** Red, green and blue in linear light, 0 ... 1. */
function linearOf([L, a, b]: Lab): Rgb {
  const l = (L + 0.3963377774 * a + 0.2158037573 * b) ** 3;
  const m = (L - 0.1055613458 * a - 0.0638541728 * b) ** 3;
  const s = (L - 0.0894841775 * a - 1.291485548 * b) ** 3;
  const inside = (x: number) => Math.min(1, Math.max(0, x));
  return [
    inside(4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s),
    inside(-1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s),
    inside(-0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s),
  ];
}

/** Of linear light to sRGB, 0 ... 1. */
export const encoded = (x: number): number => (x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055);

const steps = 256;
/** `steps` colours in linear light at equal distances along the curve. */
const table: readonly Rgb[] = (() => {
  const fine = 4096, lengths = [0];
  let last = bezier(0);
  for (let i = 1; i <= fine; ++i) {
    const next = bezier(i / fine);
    lengths.push(lengths[i - 1]! + Math.hypot(next[0] - last[0], next[1] - last[1], next[2] - last[2]));
    last = next;
  }
  let i = 0;
  return Array.from({ length: steps }, (_, k) => {
    const length = (k / (steps - 1)) * lengths[fine]!;
    while (i < fine && lengths[i + 1]! < length) ++i;
    return linearOf(bezier(Math.min(1, (i + (length - lengths[i]!) / (lengths[i + 1]! - lengths[i]! || 1)) / fine)));
  });
})();

/** The colour of 0 ... 1 in linear light; values beyond have the colours of the ends. */
export function linearColour(t: number): Rgb {
  const k = Math.round(Math.min(1, Math.max(0, t)) * (steps - 1));
  return table[Number.isNaN(k) ? 0 : k]!;
}

/** A colour in linear light as a CSS colour. */
export function cssOf(colour: Rgb): string {
  return `rgb(${colour.map((x) => Math.round(255 * encoded(x))).join(' ')})`;
}

/** Colours of vertices in linear light, n x 3. @param weights  0 ... 1: how far a value is known; 0 has colour `unknown` */
export function coloursOf(values: ArrayLike<number>, weights: ArrayLike<number>, low: number, high: number, unknown: Rgb,
  out: Float32Array): Float32Array {
  const span = high > low ? high - low : 1;
  for (let i = 0; i < values.length; ++i) {
    const w = Math.min(1, Math.max(0, weights[i]!)), colour = linearColour((values[i]! - low) / span);
    for (let k = 0; k < 3; ++k) out[3 * i + k] = w * colour[k]! + (1 - w) * unknown[k]!;
  }
  return out;
}
