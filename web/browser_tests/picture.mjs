// Saves a picture of a page, for the documentation.
// Usage, in the build's folder web/work: node browser_tests/picture.mjs PAGE.html OUT.png [SCRIPT [WIDTHxHEIGHT [light|dark [SELECTOR]]]]
// SCRIPT of docs/figures/view.png, of the demo's page: phynness.set({map: 'palpation'});
// phynness.hold([{node: 212, displacement: [0.004, 0.004, 0.0145]}])
// With SELECTOR the picture shows one element. SCRIPT of docs/figures/between_nodes_*.png, of a report with --points --body,
// 1280x900 light '#body': document.head.insertAdjacentHTML('beforeend', '<style>#body { padding: 6px 12px; }
// #body label, #body .key { display: none; } .pane canvas { height: 15rem; } .foot .legend { width: 40rem; }</style>');
// const r = phynnessReport; r.show('map 2'); r.look({...r.camera, distance: 0.95 * r.camera.distance}) (gallbladder: 0.82)
import { resolve } from 'node:path';
import { pathToFileURL } from 'node:url';
import { launch } from 'puppeteer-core';

const [file, out, script = '', size = '1280x800', scheme = 'light', selector = ''] = process.argv.slice(2);
const [width, height] = size.split('x').map(Number);
const browser = await launch({
  executablePath: '/usr/bin/chromium', headless: true,
  args: ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist'],
});
const page = await browser.newPage();
page.on('console', (message) => console.error(message.text()));
await page.setViewport({ width, height });
await page.emulateMediaFeatures([{ name: 'prefers-color-scheme', value: scheme }]);
await page.goto(pathToFileURL(resolve(file)).href);
await page.waitForFunction('globalThis.phynness || globalThis.phynnessReport');
if (script) await page.evaluate(script);
await new Promise((done) => setTimeout(done, 600));
await (selector ? await page.$(selector) : page).screenshot({ path: out });
await browser.close();
