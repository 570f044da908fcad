import { defineConfig } from 'vitest/config';

// A browser on a busy machine may take seconds to start or to compile the shaders.
export default defineConfig({ test: { include: ['browser_tests/*.test.ts'], testTimeout: 60_000, hookTimeout: 60_000, fileParallelism: false } });
