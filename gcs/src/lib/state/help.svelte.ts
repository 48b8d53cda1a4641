// Whether the list of keys is shown.
class Help {
  isOpen = $state(false);
}

export const help = new Help();
