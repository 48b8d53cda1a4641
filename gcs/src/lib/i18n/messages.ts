// All texts of the app. Each area has its own pair of files; English decides which keys there are.
import { shellEn } from './shell.en';
import { shellEs } from './shell.es';
import { mapEn } from './map.en';
import { mapEs } from './map.es';

export type Language = 'en' | 'es';

export const en = { ...shellEn, ...mapEn } as const;
export type MessageKey = keyof typeof en;

export const es: Record<MessageKey, string> = { ...shellEs, ...mapEs };

export const messages: Record<Language, Record<MessageKey, string>> = { en, es };
