// A page in a real browser, and everything that it logs or requests.
import { execFileSync } from 'node:child_process';
import { existsSync, mkdtempSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';
import { launch, type Browser, type Page } from 'puppeteer-core';

function given(name: string): string {
  const value = process.env[name];
  if (!value) throw new Error(`${name} is not set; ctest -R web sets it`);
  return value;
}

/** Paths from CMake. */
export const built = { phynness: given('PHYNNESS'), package: given('PHYNNESS_PACKAGE'), writeModels: given('PHYNNESS_WRITE_MODELS'), model: given('PHYNNESS_SAMPLE_MODEL'), source: given('PHYNNESS_SOURCE') };
export type BrowserName = 'chromium' | 'firefox';
export const browserName = given('PHYNNESS_BROWSER') as BrowserName;
export const folder = mkdtempSync(join(tmpdir(), 'phynness-browser-'));

/** Milliseconds after which a browser counts as hanging. A busy machine with software graphics has needed more than 30 s to start one. */
const patience = 240_000;

/** Runs the command. @returns its standard output */
export const phynness = (...words: string[]): string => execFileSync(built.phynness, words, { encoding: 'utf8' });

const programs: Record<BrowserName, string[]> = {
  chromium: ['/usr/bin/chromium', '/usr/bin/google-chrome'],
  firefox: ['/usr/bin/firefox-esr', '/usr/bin/firefox'],
};

/** Graphics are computed by the processor, because machines of tests have no graphics card. */
export async function start(name = browserName): Promise<Browser> {
  const executablePath = programs[name].find((path) => existsSync(path));
  if (!executablePath) throw new Error(`${name} is not installed; tools/install-deps --tests --devices installs it`);
  if (name === 'firefox')
    // Without a screen Firefox finds no WebGL; run.sh gives it a virtual one.
    return launch({ browser: 'firefox', executablePath, timeout: patience, protocolTimeout: patience, headless: false, extraPrefsFirefox: { 'webgl.force-enabled': true } });
  return launch({ executablePath, timeout: patience, protocolTimeout: patience, headless: true, args: ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist'] });
}

export interface Opened {
  readonly page: Page;
  /** messages of the console, errors and dialogs */
  readonly logged: string[];
  /** addresses of requests, without the page itself and what is inside of it */
  readonly requested: string[];
}

export async function open(browser: Browser, file: string, { ready = 'globalThis.phynness' } = {}): Promise<Opened> {
  const page = await browser.newPage(), logged: string[] = [], requested: string[] = [];
  page.setDefaultTimeout(patience);
  page.on('console', (message) => logged.push(`${message.type()}: ${message.text()}`));
  page.on('pageerror', (error) => logged.push(String(error)));
  page.on('dialog', (dialog) => {
    logged.push(`dialog: ${dialog.message()}`);
    void dialog.dismiss();
  });
  const address = pathToFileURL(file).href;
  page.on('request', (request) => {
    const url = request.url();
    if (!url.startsWith('data:') && !url.startsWith('blob:') && url.split('#')[0] !== address) requested.push(url);
  });
  await page.setViewport({ width: 1280, height: 800 });
  await page.goto(address);
  await page.waitForFunction(ready, { timeout: patience });
  return { page, logged, requested };
}

/** Colours of a picture of the page. */
export interface Pixels {
  /** red, green, blue 0 ... 255 */
  at(x: number, y: number): [number, number, number];
  readonly width: number;
  readonly height: number;
}

/** Waits until what was changed before has been drawn. */
export const drawn = (page: Page): Promise<void> =>
  page.evaluate(() => new Promise<void>((resolve) => requestAnimationFrame(() => requestAnimationFrame(() => resolve()))));

export async function pixels(page: Page): Promise<Pixels> {
  await drawn(page);
  const base64 = await page.screenshot({ encoding: 'base64' });
  const { width, height, data } = await page.evaluate(async (source) => {
    const image = new Image();
    image.src = `data:image/png;base64,${source}`;
    await image.decode();
    const canvas = document.createElement('canvas');
    canvas.width = image.width;
    canvas.height = image.height;
    const context = canvas.getContext('2d')!;
    context.drawImage(image, 0, 0);
    const bytes = context.getImageData(0, 0, image.width, image.height).data;
    let binary = '';
    for (let i = 0; i < bytes.length; i += 0x8000) binary += String.fromCharCode(...bytes.subarray(i, i + 0x8000));
    return { width: image.width, height: image.height, data: btoa(binary) };
  }, base64);
  const bytes = Buffer.from(data, 'base64');
  return {
    width, height,
    at: (x, y) => {
      const i = 4 * (Math.round(y) * width + Math.round(x));
      return [bytes[i]!, bytes[i + 1]!, bytes[i + 2]!];
    },
  };
}
