"""Recordings of joints (`trundle-recording/2`): what the importers of joint logs share."""
