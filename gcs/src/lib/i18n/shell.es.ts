// Texts of the shell, in Spanish.
import type { shellEn } from './shell.en';

export const shellEs: Record<keyof typeof shellEn, string> = {
  'app.name': 'Vencejo',
};
