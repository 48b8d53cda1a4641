// The version that this page was built from.
declare const __VERSION__: string;

export const PAGE_VERSION = __VERSION__;
