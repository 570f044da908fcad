import { defineConfig } from 'vitest/config';

const inBrowser = process.env.PHYNNESS_BROWSER !== undefined;
// Longer than `patience` of browser.ts: what hangs is named by the browser's own message.
const timeout = inBrowser ? 300_000 : 60_000;
export default defineConfig({ test: { include: [inBrowser ? 'tests/browser/*.test.ts' : 'tests/*.test.ts'], testTimeout: timeout, hookTimeout: timeout } });
