// Camera, colour map and numbers, which the pages share.
import { describe, expect, test } from 'vitest';
import { acrossScreen, facing, frameOf, framing, outsideOf, project, rayThrough, turned, type Camera } from '../shared/src/camera.js';
import { cssOf, encoded, linearColour } from '../shared/src/colour_maps.js';
import { plain, roundedDown, significant, ticks } from '../shared/src/numbers.js';
import { add, cross, dot, norm, scale, sub, type V3 } from '../shared/src/vectors.js';

const size = { width: 800, height: 600 };
const camera: Camera = { target: [0.1, -0.2, 0.3], distance: 0.7, azimuth: 0.4, elevation: 0.5 };

describe('camera', () => {
  test('the target is in the middle, and a ray through a projected point meets the point', () => {
    const middle = project(camera, size, camera.target);
    expect(middle.x).toBeCloseTo(400, 9);
    expect(middle.y).toBeCloseTo(300, 9);
    const point: V3 = [0.15, -0.1, 0.25], seen = project(camera, size, point);
    const { origin, direction } = rayThrough(camera, size, seen.x, seen.y);
    expect(norm(cross(sub(point, origin), direction))).toBeLessThan(1e-12);
  });
  test('its axes are orthogonal and right-handed', () => {
    const { right, up, forward } = frameOf(camera);
    expect(dot(right, up)).toBeCloseTo(0, 14);
    expect(norm(sub(cross(right, up), scale(-1, forward)))).toBeLessThan(1e-14);
  });
  test('a point that moves across the screen follows the pointer to a thousandth of a pixel', () => {
    const point: V3 = [0.12, -0.15, 0.28], from = project(camera, size, point);
    const to = project(camera, size, add(point, acrossScreen(camera, size, from.depth, 37, -21)));
    expect(to.x - from.x).toBeCloseTo(37, 3);
    expect(to.y - from.y).toBeCloseTo(-21, 3);
  });
  test('the probed part is seen from its own side, and a probed body from the front', () => {
    const corners: V3[] = [-1, 1].flatMap((x) => [-1, 1].flatMap((y) => [-1, 1].map((z): V3 => [x, y, z])));
    const seen = (points: V3[]) => frameOf({ target: [0, 0, 0], distance: 1, ...facing(corners.flat(), points) }).eye;
    const front = seen(corners);
    for (let axis = 0; axis < 3; ++axis)
      for (const sign of [-1, 1]) {
        const side = corners.filter((x) => x[axis] === sign), eye = seen(side);
        expect(sign * eye[axis]!).toBeGreaterThan(0.3);
        if (sign * front[axis]! > 0) expect(eye).toEqual(front);
      }
  });

  test('framing shows the whole body, on a phone, too', () => {
    const points = Float64Array.from([0, 0, 0, 0.2, 0, 0, 0.2, 0.14, 0, 0, 0.14, 0.05]);
    for (const screen of [size, { width: 360, height: 640 }]) {
      const whole = framing(points, screen);
      for (let i = 0; i < 4; ++i) {
        const { x, y } = project(whole, screen, [points[3 * i]!, points[3 * i + 1]!, points[3 * i + 2]!]);
        expect(x > 0 && x < screen.width && y > 0 && y < screen.height).toBe(true);
      }
    }
  });
  test('the eye stays away from points before it and behind it, and moves for no other reason', () => {
    const { eye, right } = frameOf(camera), least = 0.1, away = (c: Camera, p: V3) => norm(sub(frameOf(c).eye, p));
    for (const point of [add(eye, [0.01, 0, 0]), add(camera.target, scale(1.5, sub(eye, camera.target))), add(eye, scale(0.05, right))])
      expect(away(outsideOf(camera, point, least), point)).toBeGreaterThan(0.999999 * least);
    expect(outsideOf(camera, [...camera.target, ...add(eye, scale(0.2, right))], least)).toBe(camera);
  });
  test('turning stops short of the poles', () => {
    expect(turned(camera, 0, 10).elevation).toBeLessThan(Math.PI / 2);
  });
});

/** Oklab of a colour in linear light. */
function lab([r, g, b]: readonly [number, number, number]): [number, number, number] {
  const l = Math.cbrt(0.4122214708 * r + 0.5363325363 * g + 0.0514459929 * b);
  const m = Math.cbrt(0.2119034982 * r + 0.6806995451 * g + 0.1073969566 * b);
  const s = Math.cbrt(0.0883024619 * r + 0.2817188376 * g + 0.6299787005 * b);
  return [
    0.2104542553 * l + 0.793617785 * m - 0.0040720468 * s,
    1.9779984951 * l - 2.428592205 * m + 0.4505937099 * s,
    0.0259040371 * l + 0.7827717662 * m - 0.808675766 * s,
  ];
}
const steps = Array.from({ length: 16 }, (_, i) => {
  const a = lab(linearColour(i / 16)), b = lab(linearColour((i + 1) / 16));
  return { distance: Math.hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]), lightness: b[0] - a[0] };
});

describe('colour map', () => {
  test('steps are equal within 10 % and always lighter', () => {
    const mean = steps.reduce((sum, step) => sum + step.distance, 0) / steps.length;
    for (const { distance, lightness } of steps) {
      expect(Math.abs(distance / mean - 1)).toBeLessThan(0.1);
      expect(lightness).toBeGreaterThan(0.01);
    }
  });
  test('colours are encoded as sRGB, and values beyond the ends have the colours of the ends', () => {
    expect(encoded(1)).toBeCloseTo(1, 12);
    expect(cssOf([0, 1, 0.2158605])).toBe('rgb(0 255 128)'); // IEC 61966-2-1
    expect(linearColour(-1)).toEqual(linearColour(0));
    expect(linearColour(NaN)).toEqual(linearColour(0));
  });
});

describe('numbers', () => {
  test('significant digits', () => {
    expect(significant(0.0468019, 6)).toBe('0.0468019');
    expect(significant(-12.3456789, 4)).toBe('−12.35');
    expect(significant(34.6, 1)).toBe('30');
    expect(significant(0, 4)).toBe('0');
    expect(significant(NaN, 4)).toBe('–');
    expect(significant(1.5e-9, 3)).toBe('1.50e-9');
  });
  test('ticks are round and inside', () => {
    expect(ticks(0, 0.37, 4)).toEqual([0, 0.1, 0.2, 0.3]);
    expect(ticks(0, 1, 5)).toEqual([0, 0.2, 0.4, 0.6, 0.8, 1]);
    expect(ticks(3, 3)).toEqual([3]);
    expect(roundedDown(0.048)).toBe(0.02);
  });
  test('characters that cannot be seen become visible', () => {
    expect(plain('a\u202eb\u0000<script>')).toBe('a\\u{202e}b\\u{0}<script>');
    expect(plain('a\u200b\u{e0041}\ufffab')).toBe('a\\u{200b}\\u{e0041}\\u{fffa}b');
    expect(plain('x'.repeat(300))).toHaveLength(200);
  });
});
