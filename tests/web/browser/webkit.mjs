// Claims, in WebKit by its own driver: a page starts, answers as the npm package of its model, and its picture has content.
// Usage: node webkit.mjs PAGE PACKAGE_DIR     (with a screen, and WebKitWebDriver in the path)
import { spawn } from 'node:child_process';
import { readFileSync, readdirSync } from 'node:fs';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';
import { gunzipSync } from 'node:zlib';

const [page, folder] = process.argv.slice(2), { modelFromText } = await import(join(folder, 'node.js'));
const data = readFileSync(page, 'utf8').match(/id="phynness-data">([^<]*)/)[1];
const model = await modelFromText(JSON.parse(gunzipSync(Buffer.from(data, 'base64'))).model);

function fail(why) {
  console.error(`FAILED: ${why}`);
  process.exitCode = 1;
}
const libraries = '/usr/lib/x86_64-linux-gnu', versions = readdirSync(libraries).filter((name) => /^webkit2gtk-4/.test(name));
const port = 20000 + (process.pid % 20000), driver = spawn('WebKitWebDriver', [`--port=${port}`], { stdio: 'ignore' });
/** A command of the WebDriver protocol (https://www.w3.org/TR/webdriver2/). */
async function command(method, path, body) {
  const response = await fetch(`http://127.0.0.1:${port}${path}`,
    { method, ...(body ? { body: JSON.stringify(body), headers: { 'content-type': 'application/json' } } : {}) });
  const { value } = await response.json();
  if (value?.error) throw new Error(`${path}: ${value.error}: ${value.message}`);
  return value;
}
const pause = (ms) => new Promise((done) => setTimeout(done, ms));

let session;
try {
  const wanted = { 'webkitgtk:browserOptions': { binary: `${libraries}/${versions.at(-1)}/MiniBrowser`, args: ['--automation'] } };
  for (let i = 0; !session; ++i)
    try {
      session = await command('POST', '/session', { capabilities: { alwaysMatch: wanted } });
    } catch (error) {
      if (i === 40) throw error;
      await pause(250); // until the driver listens
    }
  const run = (script) => command('POST', `/session/${session.sessionId}/execute/sync`, { script, args: [] });
  await command('POST', `/session/${session.sessionId}/url`, { url: pathToFileURL(page).href });
  for (let i = 0; i < 120 && (await run('return typeof globalThis.phynness')) !== 'object'; ++i) await pause(250);
  const nodes = (await run('return [...phynness.session.runtime.active]')).slice(0, 5);
  for (const node of nodes) {
    const displacement = [0.001, -0.002, 0.004 + 0.002 * (node % 5)], expected = Math.hypot(...model.force(node, displacement).force);
    const held = JSON.stringify([{ node, displacement }]);
    const [force, shown] = await run(`phynness.hold(${held}); return [Math.hypot(...phynness.session.answer.forces[0]), document.getElementById('newtons').textContent]`);
    console.log(`node ${node}: page ${shown} N, package ${expected} N`);
    // The figure that is shown has up to three digits.
    if (!(Math.abs(force / expected - 1) < 1e-9) || !(Math.abs(shown / expected - 1) < 0.34)) fail('the page and the package differ');
  }
  const colours = await run(`phynness.view.draw(); const gl = document.getElementById('canvas').getContext('webgl2'), n = 4 * gl.drawingBufferWidth * gl.drawingBufferHeight;
    const bytes = new Uint8Array(n); phynness.view.draw(); gl.readPixels(0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
    let drawn = 0; for (let i = 3; i < n; i += 4) drawn += bytes[i] > 0; return [4 * drawn / n, bytes.some((x) => x > 0 && x < 200)];`);
  console.log(`${session.capabilities.browserName} ${session.capabilities.browserVersion}: ${(100 * colours[0]).toFixed(1)} % of the picture are drawn`);
  if (!(colours[0] > 0.05 && colours[0] < 0.95)) fail('the picture has no body');
} catch (error) {
  fail(error.message);
} finally {
  if (session) await command('DELETE', `/session/${session.sessionId}`).catch(() => {});
  driver.kill();
}
