import { defineConfig } from 'vitest/config';

// Longer than `patience` of browser.ts: what hangs is named by the browser's own message.
export default defineConfig({ test: { include: ['browser_tests/*.test.ts'], testTimeout: 300_000, hookTimeout: 300_000, fileParallelism: false } });
