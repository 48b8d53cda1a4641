// Sets the theme before the first paint, as src/lib/state/settings.svelte.ts reads it: a script of its own, since the server's
// Content-Security-Policy allows none within the page.
(() => {
  let theme = null;
  try {
    theme = JSON.parse(localStorage.getItem('vencejo.settings')).theme;
  } catch {
    // nothing is stored, or storage is switched off
  }
  const system = matchMedia('(prefers-color-scheme: dark)').matches ? 'dark' : 'light';
  document.documentElement.dataset.theme = theme === 'dark' || theme === 'light' ? theme : system;
})();
