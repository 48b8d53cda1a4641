// Which messages are shown: by severity and by words.

/** MAV_SEVERITY; smaller is worse. */
export const WARNING = 4;

interface Searchable {
  severity: number;
  text: string;
}

const plain = (text: string): string =>
  text
    .normalize('NFD')
    .replace(/\p{Diacritic}/gu, '')
    .toLowerCase();

/** Those at least as severe as `severity` that hold every word of `search`, in any order, without regard to case. */
export function filterMessages<Message extends Searchable>(
  messages: readonly Message[],
  severity: number,
  search: string,
): Message[] {
  const words = plain(search)
    .split(/\s+/)
    .filter((word) => word !== '');
  return messages.filter((message) => {
    if (message.severity > severity) return false;
    const text = plain(message.text);
    return words.every((word) => text.includes(word));
  });
}
