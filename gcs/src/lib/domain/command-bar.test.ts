import { describe, expect, it } from 'vitest';
import { commandBar, type Standing } from './command-bar';

describe('commandBar', () => {
  const free: Standing = { isRecorded: false, isOnline: true, isOperator: true, hasControl: true };

  it('lets an operator in control command, and nobody a recording', () => {
    expect(commandBar(free)).toBeNull();
    expect(commandBar({ ...free, isRecorded: true })).toBe('recording');
    expect(commandBar({ isRecorded: true, isOnline: false, isOperator: false, hasControl: false })).toBe('recording');
    expect(commandBar({ ...free, isOnline: false, hasControl: false })).toBe('away');
    expect(commandBar({ ...free, isOperator: false, hasControl: false })).toBe('watching');
    expect(commandBar({ ...free, hasControl: false })).toBe('control');
  });
});
