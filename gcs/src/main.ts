// Starts the app.
import { mount } from 'svelte';
import './tokens.css';
import './app.css';
import './controls.css';
import App from './App.svelte';
import { station } from '$lib/state/station.svelte';

// Only in `npm run dev:mock`; no build contains it.
if (import.meta.env.MODE === 'mock') (await import('../dev/mock/server')).install();

const target = document.getElementById('app');
if (target === null) throw new Error('index.html has no element #app');
mount(App, { target });
station.start();
