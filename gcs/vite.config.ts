// How the app is built, served in development and tested.
import { svelte } from '@sveltejs/vite-plugin-svelte';
import { fileURLToPath } from 'node:url';
import { defineConfig } from 'vitest/config';
import about from './package.json' with { type: 'json' };

const server = process.env['VENCEJO_SERVER'] ?? 'http://127.0.0.1:8765';

export default defineConfig(({ mode }) => ({
  plugins: [svelte()],
  define: { __VERSION__: JSON.stringify(about.version) },
  resolve: {
    alias: { $lib: fileURLToPath(new URL('./src/lib', import.meta.url)) },
    // Svelte's browser build in unit tests too: effects and runes behave as in the app.
    ...(mode === 'test' ? { conditions: ['browser'] } : {}),
  },
  build: {
    target: 'es2022',
    // The server's Content-Security-Policy allows no data: scripts, and small files stay cacheable.
    assetsInlineLimit: 0,
    sourcemap: false,
  },
  server: {
    // As if the page came from the server itself, which answers no other origin.
    proxy: { '/api': { target: server, ws: true, changeOrigin: true, headers: { origin: server } } },
  },
  test: {
    include: ['src/**/*.test.ts', 'tests/**/*.test.ts'],
    environment: 'node',
    // Only ends a test that hangs: how long one takes depends on what else the machine does.
    testTimeout: 60_000,
  },
}));
