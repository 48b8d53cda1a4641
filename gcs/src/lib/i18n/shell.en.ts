// Texts of the shell, in English.
export const shellEn = {
  'app.name': 'Vencejo',
} as const;
